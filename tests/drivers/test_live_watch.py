"""What the frame counter tells: standstill, and frames that nobody asked for."""

from ukrt.drivers.live.watch import MissingFrames, ShedWatch, StallWatch


class TestStallWatch:
    def test_standing_still_for_a_second_or_eight_blocks(self):
        def looks(frame, first, last, block_seconds):
            return [watch.look(frame, 0.05 * k, block_seconds) for k in range(first, last)]

        watch = StallWatch()
        assert not any(looks(0, 0, 20, 0.01) + looks(64, 20, 41, 0.01))  # 1 s each
        assert all(looks(64, 42, 44, 0.01))
        assert not any(looks(128, 44, 77, 0.2))  # blocks of 200 ms: 1.6 s
        assert all(looks(128, 78, 80, 0.2))
        watch.restart(4.0)
        assert not any(looks(128, 80, 100, 0.01))

    def test_who_did_not_look_himself_blames_nobody(self):
        watch = StallWatch()
        assert not watch.look(64, 10.0, 0.01)
        assert not watch.look(64, 100.0, 0.01)  # this process was stopped, and so may the other have been
        assert not watch.look(128, 100.05, 0.01)


class TestMissingFrames:
    """An output with blocks of 128 frames at 48 kHz whose lateness, gaps and clock the test makes."""

    def play(self, missing, blocks=18750, lost=lambda k: 0, late=lambda k: 0.0, clock=1.0):
        frames, gone = 0, 0
        for k in range(blocks):
            gone += lost(k)
            seconds = (k + gone) * 128 / 48000 * clock + late(k)
            if k % 19 == 0:  # twenty looks a second
                missing.look(frames, 1_000_000_000 + round(seconds * 1e9), 48000.0, 128)
            frames += 128
        return missing.frames

    def test_none_where_all_were_asked_for(self):
        assert self.play(MissingFrames()) == 0

    def test_neither_lateness_nor_a_slow_clock_is_a_gap(self):
        noise = iter(range(10**9))
        late = lambda k: 0.002 * (next(noise) * 7919 % 1000) / 1000  # noqa: E731
        assert self.play(MissingFrames(), late=late) == 0
        assert self.play(MissingFrames(), clock=1.0002) == 0
        assert self.play(MissingFrames(), clock=0.9998) == 0

    def test_every_block_that_was_left_out_counts(self):
        assert self.play(MissingFrames(), lost=lambda k: {4000: 1, 9000: 40, 9100: 2}.get(k, 0)) == 43 * 128

    def test_what_is_made_up_for_is_not_missing(self):
        """A server that stops for half a second and then calls as often as it takes to catch up."""
        late = lambda k: max(0.0, 0.5 - 0.001 * (k - 5000)) if k >= 5000 else 0.0  # noqa: E731
        assert self.play(MissingFrames(), late=late) == 0

    def test_the_time_between_two_outputs_is_not_missing(self):
        missing = MissingFrames()
        self.play(missing, 5000)
        missing.restart()
        missing.look(5000 * 128, 90_000_000_000, 48000.0, 128)
        assert missing.frames == 0 and self.play(missing, 5000) == 0

    def test_a_stamp_without_a_time_is_no_stamp(self):
        missing = MissingFrames()
        missing.look(0, 0, 48000.0, 128)
        assert self.play(missing) == 0


def test_what_is_left_out_is_told_once_and_taken_back():
    watch = ShedWatch()
    told = [watch.look(level) for level in (0, 1, 1, 3, 3, 2, 0, 0)]
    assert [sentence is not None for sentence in told] == [False, True, False, True, False, True, True, False]
    assert "too slow: strings that are nearly silent" in told[1] and "level 3" in told[3]
    assert "strings that only ring along" in told[5] and "nothing is left out" in told[6]
