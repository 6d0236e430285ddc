"""Laws of what reads and what holds: readouts, environments, streams, fields."""

import numpy as np

from rig.abilities.abilities import Burst, Environment, Field, Readout, Stream, StreamBlock
from rig.clock import Clock
from rig.description.device_settings import ReadoutSettings
from rig.errors import WaitEnded
from rig.testing.law import expect, expect_near, expect_refusal

LONGEST_S = 60.0
LARGEST_OF_RANGE = 1.25
"""No meter reads farther over its range."""
UNITS = frozenset({"g", "dps", "ut", "mps2", "v", "deg", "gauss", "radps", "degc", "kpa", "counts"})


def keep_readout_promises(readout: Readout, clock: Clock, settings: ReadoutSettings, *, nplc: float = 1.0) -> None:
    """Every channel gives as many finite readings as asked for, timed; a stop or a refusal harms no later burst."""
    readout.prepare()
    expect(bool(readout.identify()) and readout.identify() == readout.identify(), f"{readout.name}: identity changes")
    expect(all(isinstance(value, float) for value in readout.checks().values()), f"{readout.name}: checks")
    first, last = readout.channels[0], readout.channels[-1]
    began_s = clock.monotonic_s()
    burst = readout.read(first, 4, clock.sleep, nplc=nplc)
    ended_s = clock.monotonic_s()
    expect(burst.channel == first, f"{readout.name}: {first} was asked for, {burst.channel} is told")
    expect(burst.samples.shape == burst.overload.shape == (4,), f"{readout.name}: 4 readings asked, shape differs")
    expect(bool(np.isfinite(burst.samples).all()) and not burst.overload.any(), f"{readout.name}: readings are missing")
    expect(began_s <= burst.started_s <= ended_s, f"{readout.name}: the start lies outside the burst")
    expected_s = readout.reading_s(nplc)
    expect_near(burst.interval_s, expected_s, 0.5 * expected_s, f"{readout.name}: seconds between readings")
    expect(ended_s - burst.started_s >= 3.0 * burst.interval_s, f"{readout.name}: readings came faster than taken")
    for channel, samples in ((f"{readout.name}.none such", 3), (first, 0)):
        expect_refusal(
            lambda c=channel, n=samples: readout.read(c, n, clock.sleep),  # type: ignore[misc]
            f"{readout.name}: {samples} of {channel}",
            readout.name,
        )
    _keep_stated(readout, settings, burst)
    _keep_stop(readout)
    again = readout.read(last, 2, clock.sleep, nplc=nplc)
    expect(bool(np.isfinite(again.samples).all()), f"{readout.name}: the burst behind a stop is not whole")


def _keep_stated(readout: Readout, settings: ReadoutSettings, burst: Burst) -> None:
    """Hold the settings to what is read: a result's uncertainty rests on the range that they tell."""
    for name in settings.channel_names():
        range_v = settings.range_of_channel_v(name)
        expect(range_v is None or 0.0 < range_v < np.inf, f"{readout.name}: range of {name}: {range_v} V")
    range_v = settings.range_of_channel_v(burst.channel.partition(".")[2])
    if range_v is not None:
        beyond = float(np.abs(burst.samples).max()) > LARGEST_OF_RANGE * range_v
        expect(not beyond, f"{readout.name}: {burst.channel} reads more than its range of {range_v:g} V holds")
    nplc = settings.integrates_nplc
    if nplc is not None:
        expect_near(settings.reading_s(nplc), settings.reading_s(), 1e-9, f"{readout.name}: reading at {nplc:g} nplc")


def _keep_stop(readout: Readout) -> None:
    """Stop a burst: what ``wait`` raises must come out, and nothing else."""

    def stopped(duration_s: float) -> None:
        raise WaitEnded(f"stop, {duration_s:g} s early")

    try:
        readout.read(readout.channels[0], 5, stopped, nplc=10.0)
    except WaitEnded:
        return
    raise AssertionError(f"{readout.name}: a stop does not end a burst (it waits otherwise than by `wait`)")


def keep_environment_promises(
    air: Environment, clock: Clock, *, limits_degc: tuple[float, float], holds_degc: tuple[float, float], warm_s: float
) -> None:
    """Read, hold and read back inside the limits; refuse outside before anything is sent.

    ``holds_degc``: two set points; ``warm_s`` rig seconds are enough to reach the first.
    """
    expect(air.identify() == air.identify(), f"{air.name}: it says of itself one thing, then another")
    expect(bool(np.isfinite(air.temperature_degc())), f"{air.name}: the temperature is no number")
    before_degc = air.setpoint_degc()
    for wrong_degc in (limits_degc[0] - 1.0, limits_degc[1] + 1.0, float("nan")):
        expect_refusal(lambda wrong=wrong_degc: air.hold(wrong), f"{air.name}: hold {wrong_degc:g} °C", air.name)  # type: ignore[misc]
    expect_near(air.setpoint_degc(), before_degc, 1e-9, f"{air.name}: a refused set point changed it")
    for held_degc in holds_degc:
        air.hold(held_degc)
        expect_near(air.setpoint_degc(), held_degc, 1e-6, f"{air.name}: set point")
        if held_degc == holds_degc[0]:
            clock.sleep(warm_s)
            expect_near(air.temperature_degc(), held_degc, 0.3, f"{air.name}: temperature after {warm_s:g} s")


def keep_stream_promises(stream: Stream, clock: Clock) -> None:
    """Name channels and units; tell samples in order, whole and no faster than they are taken."""
    expect(bool(stream.identify()), f"{stream.name}: it does not say who it is")
    expect(set(stream.units) == set(stream.channels), f"{stream.name}: units and channels are not the same names")
    expect(set(stream.units.values()) <= UNITS, f"{stream.name}: a unit is none of {', '.join(sorted(UNITS))}")
    named = all(channel.startswith(f"{stream.name}.") for channel in stream.channels)
    expect(named, f"{stream.name}: a channel does not begin with the stream's name")
    stream.start()
    began_s = clock.monotonic_s()
    blocks: list[StreamBlock] = []
    while sum(block.samples for block in blocks) < 2.0 * stream.rate_hz and clock.monotonic_s() < began_s + LONGEST_S:
        clock.sleep(0.1)
        blocks.append(stream.poll())
    counted = [0, *(int(total) for total in np.cumsum([block.samples for block in blocks]))]
    expect([block.first for block in blocks] == counted[:-1], f"{stream.name}: running numbers do not follow")
    for block in blocks:
        shapes = {values.shape for values in block.values.values()}
        expect(block.stream == stream.name, f"{stream.name}: a block is of {block.stream}")
        expect(set(block.values) == set(stream.channels), f"{stream.name}: a block lacks a channel")
        expect(shapes == {block.device_s.shape}, f"{stream.name}: channels of a block are not as long as each other")
        expect((block.gaps, block.refused) == ((), 0), f"{stream.name}: gaps {block.gaps} on a sound line")
    polled_s = [block.polled_s for block in blocks]
    expect(polled_s == sorted(polled_s), f"{stream.name}: polls go back in time")
    expect(counted[-1] >= 2.0 * stream.rate_hz, f"{stream.name}: {counted[-1]} samples in {LONGEST_S:g} s")
    expect(polled_s[-1] - began_s >= 1.9, f"{stream.name}: samples came faster than they are taken")
    stream.stop()


def keep_field_promises(field: Field, clock: Clock, level_ut: float) -> None:
    """Refuse levels outside the limits; apply another one and tell it."""
    low_ut, high_ut = field.limits_ut
    for wrong_ut in (low_ut - 1.0, high_ut + 1.0, float("nan")):
        for request in (field.check_field, field.start_field):
            expect_refusal(lambda request=request, wrong=wrong_ut: request(wrong), f"{field.name}: {wrong_ut:g} ut")  # type: ignore[misc]
    field.start_field(level_ut)
    ends_s = clock.monotonic_s() + LONGEST_S
    while field.state().applied_ut is None and clock.monotonic_s() < ends_s:
        clock.sleep(0.1)
    read_back_ut = field.state().applied_ut
    if read_back_ut is None:
        raise AssertionError(f"{field.name}: {level_ut:g} ut is not applied within {LONGEST_S:g} s")
    expect_near(read_back_ut, level_ut, 1e-6 * max(1.0, abs(level_ut)), f"{field.name}: applied")
