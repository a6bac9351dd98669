"""Outputs: sound cards through PortAudio, and a clock that stands in for one."""
