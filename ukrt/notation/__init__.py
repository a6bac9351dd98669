"""What the left hand does, written down: fingerings as tablature, MusicXML and annotations."""
