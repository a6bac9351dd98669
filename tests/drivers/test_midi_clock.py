"""Frames for times of arrival: against simulated outputs whose blocks begin late by known amounts."""

import numpy as np
import pytest

from ukrt.drivers.midi.arrival import Arrivals
from ukrt.drivers.midi.clock import FrameClock

RATE = 48000.0


class Output:
    """An output in simulated time: block k is due at k * block / rate and begins ``lateness[k]`` seconds later."""

    def __init__(self, block=128, stamps=True):
        self.sample_rate, self.block, self._stamps = RATE, block, stamps
        self.frame, self.ns, self._stamp = 0, 10**12, (0, 0, 0)

    def now(self):
        return self.ns

    def stamp(self):
        return self._stamp if self._stamps else (0, 0, 0)

    def begin_block(self):
        self._stamp = (self.frame, self.ns, self.block)
        self.frame += self.block

    def play(self, clock, lateness, ppm=0.0, polls=4):
        """Run ``len(lateness)`` blocks; gives arrays of poll times [ns], their frames, and which were too late."""
        start, period = self.ns, self.block / self.sample_rate * 1e9 * (1 + ppm * 1e-6)
        begins = [start + round(k * period + late * 1e9) for k, late in enumerate(lateness, 1)]
        times, frames, late = [], [], 0
        for begin, following in zip(begins, begins[1:], strict=False):
            self.ns = begin
            self.begin_block()
            for part in range(polls):
                self.ns = begin + (following - begin) * part // polls
                clock.look()
                times.append(self.ns)
                frames.append(clock.acts_at(self.ns))
                late += frames[-1] < self.frame
        return np.array(times), np.array(frames), late


def make(block=128, stamps=True, **options):
    output = Output(block, stamps)
    return output, FrameClock(output, now=output.now, **options)


def delays(times, frames, start_ns, rate=RATE):
    """From each time to its frame, in frames, in an ideal output that began at ``start_ns``."""
    return frames - (times - start_ns) * 1e-9 * rate


def lateness(kind, blocks, period, rng):
    """How late blocks begin [s], as outputs do it."""
    if kind == "none":
        return np.zeros(blocks)
    if kind == "jitter":
        return rng.uniform(0.0, 0.5 * period, blocks)
    if kind == "pairs":  # two blocks at the time of the second: the first is late by a period
        return np.where(np.arange(blocks) % 2, 0.0, period - 1e-6)
    late = rng.exponential(20e-6, blocks)
    late[rng.integers(0, blocks, blocks // 50)] += 0.4 * period  # hiccups
    return late


@pytest.mark.parametrize("block", [32, 64, 256, 1024, 8192])
@pytest.mark.parametrize("kind", ["none", "jitter", "pairs", "hiccups"])
def test_the_delay_is_constant_and_nothing_comes_too_late(kind, block):
    """To 4 frames (0.1 ms), from a second after the start; where every block is late, to 2 % of a block more."""
    output, clock = make(block)
    began = output.ns
    blocks = round(5 * RATE / block)
    times, frames, late = output.play(clock, lateness(kind, blocks, block / RATE, np.random.default_rng(1)))
    late_by = delays(times, frames, began)[times > began + 10**9]
    assert np.ptp(late_by) <= (4 if kind != "jitter" else 4 + 0.02 * block)
    assert late <= len(frames) // 100
    assert clock.restarts == 0


@pytest.mark.parametrize("ppm", [-100, -20, 20, 100])
def test_follows_a_card_whose_quartz_differs(ppm):
    output, clock = make(64)
    began = output.ns
    times, frames, _ = output.play(clock, np.zeros(6000), ppm)
    late_by = delays(times, frames, began, RATE / (1 + ppm * 1e-6))
    assert np.ptp(late_by[times > began + 10**9]) <= 3


def test_one_block_or_what_is_asked_for():
    for options, expected in (({}, 128), ({"margin": 0.001}, 176), ({"delay_frames": 500}, 500)):
        output, clock = make(128, **options)
        output.begin_block()
        output.ns += 1_000_000
        clock.look()
        output.ns += 1_000_000  # 48 frames later
        assert abs(clock.acts_at(output.ns) - (expected + 96)) <= 1
        assert abs(clock.acts_at(output.ns - 500_000) - (expected + 72)) <= 1


def test_frames_lost_in_a_gap_are_given_up_within_a_second():
    output, clock = make(64)
    output.play(clock, np.zeros(800))
    gap = 0.004  # 192 frames that the server never asked for
    output.ns += round(gap * 1e9)
    began = output.ns - output.frame / RATE * 1e9
    times, frames, late = output.play(clock, np.zeros(1600))
    late_by = delays(times, frames, began)
    first, last = late_by[:100], late_by[times > times[0] + 10**9]
    assert first.max() > last.max() + 150  # later than need be at first, never too late
    assert np.ptp(last) <= 3 and late == 0
    assert clock.restarts == 1


@pytest.mark.parametrize("seconds", [0.2, 5.0, 3600.0])
def test_a_new_line_after_standing_still(seconds):
    """Suspend, a dead server: frames neither run on meanwhile nor are far ahead afterwards."""
    output, clock = make(128)
    output.play(clock, np.zeros(500))
    before = output.frame
    output.ns += round(seconds * 1e9)
    clock.look()
    assert before <= clock.acts_at(output.ns) <= before + 3 * 128 + 0.05 * RATE
    began = output.ns - output.frame / RATE * 1e9
    times, frames, late = output.play(clock, np.zeros(200))
    assert np.ptp(delays(times, frames, began)) <= 3 and late == 0


def test_another_rate_and_another_block_size():
    output, clock = make(128)
    output.play(clock, np.zeros(500))
    output.sample_rate, output.block = 96000.0, 512
    began = output.ns - output.frame / 96000.0 * 1e9
    times, frames, late = output.play(clock, np.zeros(300))
    assert np.ptp(delays(times, frames, began, 96000.0)) <= 3 and late == 0
    output.block = 64
    began = output.ns - output.frame / 96000.0 * 1e9
    times, frames, late = output.play(clock, np.zeros(3000))
    assert np.ptp(delays(times, frames, began, 96000.0)[times > times[0] + 10**9]) <= 3 and late == 0


def test_frames_that_begin_again():
    output, clock = make(128)
    output.play(clock, np.zeros(500))
    output.frame = 0
    output.ns += 1_000_000
    _, frames, late = output.play(clock, np.zeros(10))
    assert frames.max() < 13 * 128 and late == 0


def test_without_stamps_the_counter_is_watched():
    output, clock = make(128, stamps=False)
    began = output.ns
    times, frames, late = output.play(clock, np.zeros(1000), polls=8)
    late_by = delays(times, frames, began)[times > began + 10**9]
    assert np.ptp(late_by) <= 3 and late == 0
    assert all(output.frame <= clock.frame() <= output.frame + 128 for _ in range(3))


def test_before_the_first_block_everything_is_soon():
    _, clock = make(128)
    assert 0 <= clock.frame() <= 0.05 * RATE


class TestArrivals:
    """Messages that come at known times and are polled later, on a machine that is busy."""

    def polled(self, arrivals, rng, wait, lost=()):
        """Errors of the estimate [ms] for messages at ``arrivals`` [ns], each polled ``wait`` [s] later at most."""
        times, before, errors, polled = Arrivals(), None, [], 0
        for k, at in enumerate(arrivals):
            since = 0.0 if before is None else round((at - before) / 1000) * 1e-6
            before = at
            if k in lost:
                continue
            polled = max(polled, at + round(rng.uniform(0.0, wait) * 1e9))
            found = times.at(since, polled)
            assert polled - 50_000_000 <= found <= polled
            errors.append((found - at) * 1e-6)
        return np.array(errors)

    def test_the_wait_for_the_poll_is_taken_out(self):
        rng = np.random.default_rng(2)
        arrivals = 10**12 + np.cumsum(rng.integers(1_000_000, 5_000_000, 5000))
        errors = self.polled(arrivals.tolist(), rng, 0.004)
        assert np.ptp(errors[100:]) < 0.2  # where polling alone gives 4

    def test_times_that_cannot_be_are_replaced_by_the_poll(self):
        times = Arrivals()
        assert times.at(0.0, 10**12) == 10**12
        assert times.at(0.0, 10**12 + 10**9) == 10**12 + 10**9  # a clock that stands still
        assert times.at(-5.0, 10**12 + 2 * 10**9) == 10**12 + 2 * 10**9
        assert times.at(1e6, 10**12 + 3 * 10**9) == 10**12 + 3 * 10**9  # one that jumps

    def test_lost_messages_do_no_lasting_harm(self):
        """A queue that overflowed has lost 20 ms of time as well; a second later all is as before."""
        rng = np.random.default_rng(3)
        arrivals = (10**12 + 2_000_000 * np.arange(3000)).tolist()
        errors = self.polled(arrivals, rng, 0.001, lost=range(1000, 1010))
        assert np.abs(errors[1600:]).max() < 1.0
