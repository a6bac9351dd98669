"""The status line: what stands in it, that it fits, and that it is only for terminals."""

import io

import pytest
from rich.console import Console

from ukrt.cli.status import ASCII_SIGNS, Moment, StatusLine, compose

BUSY = Moment(
    seconds=723,
    output="system (JACK Audio Connection Kit)",
    rate_hz=48000,
    block=64,
    loads=(0.12, 0.183, 0.351),
    xruns=3,
    late=14,
    missing=7,
    ports=2,
    messages_per_s=120,
    notes=6,
    peak_db=-12.3,
    limiter_db=-0.4,
    shed=2,
    recording_s=63,
    piece_s=12,
    piece_of_s=74,
    trouble=True,
)


@pytest.mark.parametrize("moment", [BUSY, Moment(seconds=1), Moment(seconds=4000, notes=6, recording_s=3999)])
@pytest.mark.parametrize("width", [*range(1, 40, 7), 60, 79, 80, 100, 120, 200])
@pytest.mark.parametrize("signs", [{}, {"signs": ASCII_SIGNS}])
def test_fits_everywhere(moment, width, signs):
    line = compose(moment, width, **signs)
    assert 0 < line.cell_len <= width and "\n" not in line.plain
    if signs:
        assert line.plain.isascii()


def test_says_all_there_is_where_there_is_room():
    line = compose(BUSY, 200).plain
    parts = (
        "12:03",
        "piece 0:12 of 1:14",
        "system (JACK",
        "48 kHz, 64",
        "load 12 18 35 %",
        "xruns 3 late 14 missing 7",
    )
    parts += ("shedding 2", "MIDI 2 in, 120/s", "♪ 6", "-12.3 dBFS █", "limiter -0.4 dB", "● 1:03")
    assert [part for part in parts if part not in line] == []


@pytest.mark.parametrize("width", [80, 120])
def test_what_matters_on_stage_is_there_at_usual_widths(width):
    line = compose(BUSY, width).plain
    parts = ("12:03", "12 18 35", "3/14/7", "shed 2", "120/s", "♪ 6", "-12.3", "█", "● 1:03")
    assert [part for part in parts if part not in line] == []


def test_the_bar_grows_with_the_level():
    bars = [compose(Moment(seconds=1, peak_db=db), 120).plain.count("█") for db in (-200, -60, -30, -12, 0, 3)]
    assert bars == sorted(bars) and bars[0] == bars[1] == 0 and bars[2] > 0 and bars[-1] == bars[-2] > bars[-3]


def test_a_quiet_line_does_not_move_from_one_moment_to_the_next():
    """Numbers that change all the time take the same room."""
    lines = [
        compose(Moment(seconds=60, loads=(load,) * 3, ports=1, messages_per_s=rate, peak_db=db), 120).plain
        for load in (0.03, 0.42)
        for rate in (0, 7, 120)
        for db in (-50.0, -9.9, -0.1)
    ]
    assert len({(len(line), line.index("MIDI"), line.index("dBFS")) for line in lines}) == 1


class TestStatusLine:
    def test_news_stand_above_the_line(self):
        console = Console(file=io.StringIO(), force_terminal=True, width=80, _environ={"TERM": "xterm"})
        with StatusLine(console=console) as status:
            assert status.shown
            status.show(BUSY)
            status.say("the server has [died]")
            status.show(BUSY)
        out = console.file.getvalue()
        assert "ukrt: the server has [died]\n" in out and out.count("3/14/7") >= 2

    @pytest.mark.parametrize("wanted", [True, False])
    def test_elsewhere_only_the_news(self, capsys, wanted):
        console = Console(file=io.StringIO())
        with StatusLine(wanted, console=console) as status:
            assert not status.shown
            status.show(BUSY)
            status.say("hello")
        assert console.file.getvalue() == "" and capsys.readouterr().err == "ukrt: hello\n"

    def test_a_terminal_that_goes_away_does_not_end_the_music(self):
        class Gone(io.StringIO):
            def write(self, text):
                raise OSError(5, "Input/output error")

        file = io.StringIO()
        console = Console(file=file, force_terminal=True, width=80, _environ={"TERM": "xterm"})
        with StatusLine(console=console) as status:
            status.show(BUSY)
            console.file = Gone()
            status.show(BUSY)
            status.say("who hears this?")
