"""What was played, kept to be played again bit for bit."""
