"""How fast this machine computes the guitar, and how near that is to what its processor can do at all."""
