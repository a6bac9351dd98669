"""What knobs mean: the table, alike in plain Python and compiled; the lanes' writers; the file it is kept in."""

import re
import threading

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_midi_merge import World

from ukrt.drivers.midi.listen import CHATTER, SETTLE_SECONDS, Listener
from ukrt.drivers.midi.mapping import Mapped, Mapping, load_mapping, mapping_path, mapping_text
from ukrt.engine import stage_layout as at
from ukrt.engine.controller_layout import CONTROLLERS
from ukrt.engine.controller_names import FUNCTIONS, NO_KNOBS
from ukrt.engine.map_layout import DROPPED, mapped
from ukrt.engine.stage import Stage
from ukrt.errors import PresetError


@pytest.fixture
def stage():
    stage = Stage(2)
    stage.reset(48000.0)
    return stage


def word(status, data1=0, data2=0):
    return status << 16 | data1 << 8 | data2


_word = st.builds(word, st.integers(0x80, 0xFF), st.integers(0, 127), st.integers(0, 127))
_source = st.one_of(
    st.sampled_from(["pressure", "bend"]),
    st.integers(0, 119).filter(lambda n: n not in NO_KNOBS).map(lambda n: f"CC {n}"),
)
_data = st.integers(0, 127)
_one = st.builds(
    Mapped, st.sampled_from([*FUNCTIONS, "nothing"]), _source, st.integers(0, 16), st.integers(0, 16), _data, _data
)


@settings(deadline=None)  # the first example compiles
@given(st.lists(_one, max_size=4), st.lists(_word, min_size=1, max_size=30))
def test_what_is_not_mapped_means_itself_and_the_compiled_twin_agrees(ones, words):
    from ukrt.engine.kernels.jack import _mapped

    mapping = Mapping()
    for one in ones:
        mapping = mapping.learned(one)
    stage = Stage(2)
    stage.set_map(mapping.table())
    sources = {(channel, one.number): one for one in mapping.controllers for channel in one.channels}
    for message in words:
        meant = mapped(stage.si, message)
        assert _mapped(stage.si, message) == meant
        kind, channel, first = message >> 16 & 0xF0, message >> 16 & 0x0F, message >> 8 & 0x7F
        source = {0xB0: first, 0xD0: 128, 0xE0: 129}.get(kind)
        one = sources.get((channel, source))
        if one is None:
            assert meant == message
        elif one.function == "nothing":
            assert meant == DROPPED
        else:
            plays = (one.plays_channel or channel + 1) - 1
            value = first if kind == 0xD0 else message & 0x7F
            exact = one.low + (one.high - one.low) * value / 127
            assert meant >> 8 == (0xB0 | plays) << 8 | FUNCTIONS[one.function] and abs((meant & 0x7F) - exact) <= 0.5


def test_its_ends_are_exact_and_it_can_work_the_other_way_round(stage):
    stage.set_map(Mapping((Mapped("place", "CC 30", 0, 0, 100, 20),)).table())
    assert [mapped(stage.si, word(0xB4, 30, value)) & 0x7F for value in (0, 127)] == [100, 20]


def test_nothing_is_read_beyond_the_tables(stage):
    stage.set_map(Mapping((Mapped("place", "CC 30"),)).table())
    for which in (-1, 3, 1 << 40):
        stage.si[at.G_MAP] = which
        assert mapped(stage.si, word(0xBF, 30, 5)) == word(0xBF, 30, 5)


def test_a_table_is_replaced_at_once_while_it_is_read(stage):
    """Whoever reads sees one mapping or the other, never a third."""
    tables = [Mapping((Mapped(function, "CC 30"),)).table() for function in ("place", "mute")]
    stage.set_map(tables[0])
    ended = threading.Event()

    def replace():
        while not ended.is_set():
            for table in tables:
                stage.set_map(table)

    thread = threading.Thread(target=replace)
    thread.start()
    try:
        seen = {mapped(stage.si, word(0xB0, 30, 5)) for _ in range(20000)}
    finally:
        ended.set()
        thread.join()
    assert seen <= {word(0xB0, 74, 5), word(0xB0, 19, 5)}


def test_an_input_that_goes_lets_go_of_a_pedal_that_only_the_map_makes_one():
    world = World()
    stage = Stage(2)
    stage.si = world.si
    stage.set_map(Mapping((Mapped("pedal", "CC 30"), Mapped("nothing", "CC 7"))).table())
    keys = world.add("keys")
    keys.waiting = [(0xB2, 30, 127), (0xB2, 7, 90), (0x92, 60, 1), (0x82, 60, 0)]
    world.poll(1)
    world.merger.remove(keys, "has gone")
    assert world.written() == [(1, 0xB2, 64, 127), (1, 0x92, 60, 1), (1, 0x82, 60, 0), (1, 0xB2, 64, 0)]
    assert world.merger.received == 4 and stage.si[at.LANE_REFUSED + at.LANE_STEP + at.LANE_UNMAPPED] == 1


def test_every_controller_has_a_name_by_which_it_is_learned():
    said = " ".join(message for message, _ in CONTROLLERS)
    numbers = {int(number) for number in re.findall(r"\bCC (\d+)", said)}
    assert numbers - set(NO_KNOBS) == set(FUNCTIONS.values()) and len(set(FUNCTIONS.values())) == len(FUNCTIONS)


# The file -------------------------------------------------------------------------------------------------------------
def test_what_is_kept_is_what_was_learned(tmp_path):
    mapping = Mapping((Mapped("vibrato", "CC 30", 3), Mapped("mute", "pressure", 0, 2, 127, 0)))
    path = tmp_path / "mine.toml"
    path.write_text(mapping_text(mapping), encoding="utf-8")
    assert load_mapping(path) == mapping


def test_its_place_is_the_platforms_or_what_the_environment_says(monkeypatch, tmp_path):
    monkeypatch.setenv("UKRT_CONFIG_DIR", str(tmp_path))
    assert mapping_path() == tmp_path / "controllers.toml"
    monkeypatch.delenv("UKRT_CONFIG_DIR")
    assert "ukrt" in mapping_path().parts


ONE = "[[controllers]]\nfunction = 'mute'\nsource = "


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("[[controllers]]\nfunction = 'vibrat'\nsource = 'CC 1'", "controllers.0.function is 'vibrat', but it must be"),
        ("[[controllers]]\nfunction = 'mute'", "controllers.0.source is missing"),
        (f"{ONE}'CC 120'", "controllers.0.source is 'CC 120', but it must be \"CC 0\" to"),
        (f"{ONE}'CC 98'", "banks, data entry and its parameter numbers"),
        (f"{ONE}'bend'\nchannel = 17", "controllers.0.channel is 17, but it must be a whole number from 0 to 16"),
        (f"{ONE}'bend'\nlow = -1", "controllers.0.low is -1, but it must be a whole number from 0 to 127"),
        (f"{ONE}'bend'\nlov = 1", 'did you mean "low"?'),
        (
            f"{ONE}'CC 2'\n{ONE}'CC 2'\nchannel = 4",
            "controllers.1.source is 'CC 2', but controllers.0 is the same on channel 4",
        ),
        ("controllers = 3", "controllers"),
        ("[[controllers]", "is not valid TOML"),
    ],
)
def test_a_wrong_file_is_refused_with_its_name_and_the_key(tmp_path, content, words):
    path = tmp_path / "wrong.toml"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(PresetError) as caught:
        load_mapping(path)
    assert str(path) in str(caught.value) and words in str(caught.value) and "\n" not in str(caught.value)


# Listening ------------------------------------------------------------------------------------------------------------
def sweep(listener, status, number, values, now=0.0):
    for value in values:
        listener.take(word(status, number, value), now)


def test_the_knob_that_moves_farthest_counts_once_it_rests():
    listener = Listener()
    sweep(listener, 0xB0, 7, (63, 64, 63, 65), 0.3)  # worn out
    assert listener.gesture(5.0) is None and CHATTER > 2
    sweep(listener, 0xB0, 20, range(10), 5.0)
    sweep(listener, 0xB2, 30, range(90, 20, -2), 5.1)
    assert listener.gesture(5.1 + 0.9 * SETTLE_SECONDS) is None
    heard = listener.gesture(5.2 + SETTLE_SECONDS)
    assert (heard.source, heard.channel, heard.low, heard.high) == ("CC 30", 3, 22, 90)


def test_a_button_that_sends_one_value_is_heard():
    listener = Listener()
    sweep(listener, 0xB0, 85, (127,))
    assert listener.gesture(1.0).source == "CC 85"


def test_pressure_and_bend_are_heard_and_notes_and_parameter_numbers_are_not():
    listener = Listener()
    for message in (word(0x90, 60, 90), word(0xB0, 99, 4), word(0xB0, 98, 100), word(0xB0, 6, 9), word(0xB0, 123, 0)):
        listener.take(message, 0.0)
    assert listener.gesture(9.0) is None and listener.notes_channel == 1
    for value in range(0, 100, 9):
        listener.take(word(0xD1, value), 9.0)
    assert listener.gesture(10.0).source == "pressure"
    listener.restart()
    sweep(listener, 0xE0, 0, range(64, 128))
    heard = listener.gesture(11.0)
    assert (heard.source, heard.high) == ("bend", 127)


def test_learning_again_replaces_the_source_and_the_function():
    mapping = Mapping((Mapped("vibrato", "CC 30", 1), Mapped("mute", "CC 31", 1), Mapped("vibrato", "CC 2", 2)))
    again = mapping.learned(Mapped("vibrato", "CC 31", 1))
    words = ["CC 2 of channel 2 plays vibrato", "CC 31 of channel 1 plays vibrato"]
    assert [str(one) for one in again.controllers] == words
    assert again.without("vibrato") == Mapping()
