"""Parameters: every field refuses what lies outside its own declared range, in one sentence that names key, value and
range; combinations that make no instrument are refused too."""

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ukrt.errors import ParameterError, PresetError, UkrtError
from ukrt.model import fields
from ukrt.model.parameters import Body, Contact, Damper, Finger, Guitar, Pluck
from ukrt.model.presets import load_preset


def numeric_fields():
    """(object, field name, rule) of everything with a range in the default guitar."""
    guitar = load_preset("classical")
    parts = [guitar.strings[0], guitar.body, guitar.finger.contacts[0], guitar.finger, guitar.damper]
    parts += [guitar.pluck, guitar.radiation, guitar.playing, guitar.tuning, guitar.basis]
    for part in parts:
        for field in dataclasses.fields(part):
            rule = field.metadata["legal"]
            if rule.kind in ("number", "integer", "numbers"):
                yield pytest.param(part, field.name, rule, id=f"{type(part).__name__}.{field.name}")


@pytest.mark.parametrize("part, name, rule", list(numeric_fields()))
def test_out_of_range_is_refused_naming_key_value_and_range(part, name, rule):
    old = getattr(part, name)
    for bad in (math.nextafter(rule.low, -math.inf), math.nextafter(rule.high, math.inf), math.nan, math.inf):
        key = name
        if rule.kind == "integer":
            bad = rule.low - 1 if bad < rule.low else rule.high + 1
        value = bad
        if rule.kind == "numbers":
            value, key = (bad, *old[1:]), f"{name}.0"
        with pytest.raises(ParameterError) as caught:
            dataclasses.replace(part, **{name: value})
        assert caught.value.key == key
        assert f"from {rule.low:g} to {rule.high:g}" in str(caught.value)
        assert repr(bad) in str(caught.value)
        assert rule.unit in str(caught.value)


@pytest.mark.parametrize("part, name, rule", list(numeric_fields()))
def test_wrong_types_are_refused(part, name, rule):
    for bad in ("12", None, True, {}, 1j):
        with pytest.raises(ParameterError, match=name):
            dataclasses.replace(part, **{name: bad})


def test_every_field_is_declared_with_words():
    described = list(fields.describe(Guitar))
    assert len(described) > 40
    for key, rule, _ in described:
        assert rule.doc and "\n" not in rule.doc, key
        if rule.kind in ("number", "integer", "numbers"):
            assert math.isfinite(rule.low) and math.isfinite(rule.high), key


@given(st.floats(0, 1e-4), st.floats(0, 10), st.floats(0, 1e8))
def test_contacts_are_one_of_three_kinds_or_refused(mass, damping, stiffness):
    try:
        contact = Contact(0.0, mass, damping, stiffness)
    except ParameterError as error:
        assert error.key in ("mass", "damping")
        assert (mass < 1e-5 and stiffness > 0) or 0 < mass < 1e-5 or (mass == 0 and damping == 0)
    else:
        assert contact.kind == ("oscillator" if mass > 0 else "damper")
        assert mass > 0 or (stiffness == 0 and damping > 0)


def test_a_rigid_contact_needs_nothing_else():
    assert Contact(0.0, rigid=True).kind == "rigid"


@pytest.mark.parametrize(
    "first, second, gap",
    [
        (Contact(0.0, rigid=True), Contact(-0.0009, rigid=True), "0.001"),
        (Contact(0.0, 5e-3, 1.0, 1e6), Contact(0.0, 5e-3, 1.0, 1e4), "0.0001"),
    ],
)
def test_contacts_must_be_apart(first, second, gap):
    with pytest.raises(ParameterError, match=rf"contacts\.1\.offset.*at least {gap} m"):
        Finger((first, second))


def test_contacts_a_millimetre_apart_may_be_rigid():
    assert len(Finger((Contact(0.0, rigid=True), Contact(-0.001, rigid=True))).contacts) == 2


def test_cross_checks():
    guitar = load_preset("classical")
    with pytest.raises(ParameterError, match=r"damper\.places.*at most 2"):
        dataclasses.replace(guitar, damper=Damper((0.8, 0.85, 0.9)))
    with pytest.raises(ParameterError, match="force_strong"):
        dataclasses.replace(guitar.pluck, force_strong=0.1)
    with pytest.raises(ParameterError, match=r"shapes_bass.*2 numbers"):
        Body((90.0, 180.0), (0.01, 0.01), (0.1, 0.1), (1.0,), (1.0, 1.0))
    with pytest.raises(ParameterError, match=r"finger\.contacts\.0\.offset.*first fret"):
        dataclasses.replace(guitar, finger=Finger((Contact(-0.05, 5e-3, 1.0, 1e6),)))
    with pytest.raises(ParameterError, match=r"strings.*1 to 12"):
        dataclasses.replace(guitar, strings=())
    with pytest.raises(ParameterError, match=r"strings\.1"):
        dataclasses.replace(guitar, strings=(guitar.strings[0], "E2"))


def test_numbers_become_plain_and_objects_hashable():
    pluck = Pluck(1 / 2, 0, 0.01, 1, 5)
    assert type(pluck.angle) is float and type(pluck.force_strong) is float
    assert hash(load_preset("classical")) == hash(load_preset("classical"))
    with pytest.raises(dataclasses.FrozenInstanceError):
        pluck.angle = 1.0


def test_text_must_be_text():
    guitar = load_preset("classical")
    for bad in (3, None, "\udc80"):
        with pytest.raises(ParameterError, match="description"):
            dataclasses.replace(guitar, description=bad)


def test_error_tree_and_prefixes():
    inner = ParameterError("tension", 900.0, "it must be a number from 1 to 500 N")
    assert str(inner.under("strings.0")) == "strings.0.tension is 900.0, but it must be a number from 1 to 500 N"
    assert issubclass(PresetError, ParameterError) and issubclass(ParameterError, UkrtError)
