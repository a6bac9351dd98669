"""What the instrument is: frozen SI parameters, their presets, and the modal subsystems and constraints they make."""
