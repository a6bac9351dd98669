"""MIDI inputs through RtMidi, in a process of their own."""
