"""Laws of jogs on a line that strikes: whatever becomes of one command or one reply, nothing strays or goes on.

The command as a person calls it, over TCP, with its stop guard. The bounds count what a busy bench costs; those of the
supervisor itself are in virtual time (``tests/rig/motion/test_supervisor.py``).
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest
from command_strikes import StrikeOn, a_command
from reply_strikes import a_reply
from struck_jogs import AT_REST_DEG, CLOSE_DEG, STRIKES, JogBench, jog_bench, strike_jog

BenchOf = Callable[[str], JogBench]


@pytest.fixture(scope="module")
def bench_of(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BenchOf]:
    benches: dict[str, JogBench] = {}
    with ExitStack() as stack:

        def made(driver: str) -> JogBench:
            if driver not in benches:
                benches[driver] = stack.enter_context(jog_bench(tmp_path_factory.mktemp(driver), driver))
            return benches[driver]

        yield made


def _holds(bench: JogBench, job: str, on: StrikeOn, kind: str, seed: int) -> None:
    story = strike_jog(bench, job, on, kind, seed)
    assert story.outside_deg <= story.allowed_deg, story
    assert story.moved_after_deg <= AT_REST_DEG, story
    if story.status == 0:
        assert story.from_target_deg <= CLOSE_DEG, f"believed, and not so: {story}"


@pytest.mark.parametrize(
    ("driver", "job", "on", "kind"),
    [
        ("zaber", "rate", a_command, "doubled"),
        ("indexing-table", "to", a_command, "value"),
        ("maestro", "to", a_reply, "value"),
        ("indexing-table", "home", a_reply, "word"),
    ],
)
def test_a_jog_on_a_line_that_strikes_ends_at_rest_and_tells_the_truth(
    bench_of: BenchOf, driver: str, job: str, on: StrikeOn, kind: str
) -> None:
    _holds(bench_of(driver), job, on, kind, 1)


@pytest.mark.soak
@pytest.mark.parametrize(("driver", "job", "on", "kind"), STRIKES)
def test_a_jog_on_a_line_that_strikes_ends_at_rest_at_length(
    bench_of: BenchOf, driver: str, job: str, on: StrikeOn, kind: str
) -> None:
    for seed in (11, 12, 13):
        _holds(bench_of(driver), job, on, kind, seed)
