"""x"""
from ukrt.playing.note_log import read_counters, read_note_log  # noqa: F401
from ukrt.playing.player_tables import make_player_tables as fill_player  # noqa: F401
