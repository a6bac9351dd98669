"""MIDI files in, audio files out, and playing one into the other."""
