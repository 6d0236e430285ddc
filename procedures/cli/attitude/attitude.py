"""``calrig attitude``: readings of a calibrated package to angles with standard deviations, from a file or a stream."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ams.inference.gyros.aided_rates import AidedAngles
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import GyroAngles
from ams.inference.inference import Package, inference
from ams.inference.package.alignment import as_mounted, load_alignment
from ams.inference.rows.angle_stream import AngleStream
from ams.inference.watch.doubts import doubts_of
from ams.inference.watch.standing_outputs import StandingOutputs
from ams.inference.watch.watched_axes import Stretch, watched_axes
from ams.sets.dated_ahead import ahead_of_clock
from ams.sets.instructions import mount_in_words
from ams.sets.triad_section import has_unmeasured_directions
from ams.sets.verdict_conditions import DIRECTIONS_NOT_MEASURED
from procedures.cli.attitude.answered_rows import Answers, answer_all, is_sent, path_of
from procedures.cli.attitude.known_attitudes import TAKEN_AS_EXACT, known_attitudes
from procedures.cli.attitude.looked_after import LookedAfter
from procedures.cli.attitude.package_file import package_of
from procedures.cli.attitude.rig_stream import StreamWiring, stream_wiring
from procedures.cli.attitude.source import Named, OfGyros, OfSamples, angles_of_gyros, monitored, used_at
from procedures.cli.attitude.uncounted import few_degrees_of_freedom, untested_shifts
from procedures.cli.attitude.unseen import tell_unseen
from procedures.cli.attitude.untested import (
    SD_OF_A_READING,
    assumed_gravity,
    assumed_of_filter,
    assumed_of_gyros,
    remarks_on_rest,
    rows_without_temperature,
    undetermined_terms,
    untested_temperature,
    untold_curvature,
)
from procedures.cli.options import Json, require_folder_of
from procedures.cli.output import note
from procedures.errors import RequestError


def attitude(
    coefficient_set: Path,
    data: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    /,
    *,
    rig: Path | None = None,
    stream: str | None = None,
    for_s: Annotated[float | None, Parameter(name="--for")] = None,
    out: str | None = None,
    axis: Named = None,
    model_set: Path | None = None,
    model_axis: Named = None,
    reading_sd_v: float | None = None,
    gravity_mps2: float | None = None,
    gravity_uncertainty_mps2: float | None = None,
    package_axes: Annotated[bool, Parameter(negative=())] = False,
    alignment: Path | None = None,
    solve_alignment: Path | None = None,
    known_sd_deg: float | None = None,
    upright: bool = True,
    right_wing_down: bool = True,
    intervals: bool = False,
    view: bool = False,
    plot: Path | None = None,
    json: Json = False,
    gyros: OfGyros | None = None,
    samples: OfSamples | None = None,
) -> None:
    """Turn outputs into angles with standard deviations.

    Of accelerometers at rest, row by row; of gyros from a start, sample by sample, with what the angles have grown to
    lack; of gyros and accelerometers together by a Kalman filter. The answer has the columns pitch_deg, pitch_sd_deg,
    roll_deg, roll_sd_deg, for gyros and a sting package yaw_deg and yaw_sd_deg, and flag, one row for each row of the
    data. An angle that the outputs do not tell is an empty cell, and flag names why.

    Parameters
    ----------
    coefficient_set
        A set of accelerometers, one, two or three axes, or of three gyros, of any format.
    data
        A CSV, Parquet or HDF5 file of any size, or - for rows that arrive on standard input, header first; what has
        arrived is answered at once. Also socket://HOST:PORT and udp://HOST:PORT. None with --rig and --stream.
    rig
        With --stream, instead of DATA: a rig file, whose stream is read as it comes. Nothing else of the rig is opened,
        and nothing moves.
    stream
        The stream of --rig, such as imu. Its channels are those that the rig file wires to the set's sensor, or those
        named by --axis AXIS=CHANNEL, such as x=imu.ax.
    for_s
        With --stream: how long to read, seconds; by default until Ctrl-C.
    out
        The file to write, .csv, .jsonl (JSON lines) or .parquet, or udp://HOST:PORT for JSON lines in datagrams; by
        default CSV on standard output.
    axis
        AXIS=COLUMN where the columns are not called x_v, y_v, z_v; only the axes named are used.
    model_set
        With a sting package: the set of the model package, for roll as well; its columns are model_x_v and so on.
    model_axis
        AXIS=COLUMN for the model package.
    reading_sd_v
        Standard deviation of one reading where the set is used; by default the calibration's standard error.
    gravity_mps2
        Local gravity where accelerometers are used; by default that of the calibration, which sets are in.
    gravity_uncertainty_mps2
        Standard uncertainty of --gravity-mps2, counted in the angles of accelerometers at rest; by default none is.
    package_axes
        The angles are those of the package's own axes, as the mount of its calibration declares them; by default those
        of the fixture on which it was calibrated.
    alignment
        How the package sits in the model, as --solve-alignment stored it: the angles are the model's.
    solve_alignment
        Store that file: DATA has, beside the outputs of three axes, pitch_deg and roll_deg of the model as they are
        known, two attitudes or more.
    known_sd_deg
        With --solve-alignment: standard uncertainty of what all known attitudes are wrong by alike, such as the zero
        of the reference and how it sits on the model, about each axis; by default they count as exact but for their
        scatter.
    upright
        Two axes have two answers: of x and y, roll within ±90° (upright) or beyond.
    right_wing_down
        Of x and z, roll from 0° to 180° (right wing down) or from −180° to 0°.
    intervals
        Also pitch_half_95_deg and so on: half-widths of 95 % intervals, by Student's factor for what the calibration
        rests on.
    view
        Show the newest attitude of a stream on the terminal, with its uncertainty, rate and loss; with --out the
        answers are written as well.
    plot
        An SVG file: every angle along the rows with its band, and its standard deviation against pitch.
    json
        Print one JSON document on standard output, with --out: how many rows, and what they do not show of the outputs.
    """
    require_folder_of(plot, "--plot")
    if json and (out is None or view):
        raise RequestError("--json: standard output is for it alone: give --out, and no --view; nothing was read")
    if not is_sent(out):
        require_folder_of(path_of(out), "--out")
    wiring = _wiring(data, rig, stream, for_s)
    package = package_of(coefficient_set, axis, "--axis", "", wiring=wiring)
    if package_axes:
        package = _in_package_axes(package, alignment, solve_alignment)
    package = _where_it_is_used(package, gravity_mps2, gravity_uncertainty_mps2, alignment, solve_alignment)
    second = None
    if model_set is not None:
        of_model = package_of(model_set, model_axis, "--model-axis", "model_", wiring=wiring)
        second = used_at(of_model, gravity_mps2, gravity_uncertainty_mps2)
    elif model_axis:
        raise RequestError("--model-axis: belongs to --model-set, which is missing")
    geometry = {"upright": upright, "right_wing_down": right_wing_down, "intervals": intervals}
    beside: dict[str, object] = {"--out": out, "--view": view, "--plot": plot, "--intervals": intervals}
    beside |= {"--alignment": alignment, "--package-axes": package_axes, "--model-set": model_set, "--json": json}
    beside |= {"what belongs to gyros": gyros, "filters and averages": samples}
    known = known_attitudes(data, solve_alignment, known_sd_deg, [name for name, given in beside.items() if given])
    if known is not None:
        known.store_alignment_of(package, reading_sd_v)
        return
    settings, stated = gyros or OfGyros(), samples or OfSamples()
    is_integrated = package.senses_rates or settings.gyro_set is not None
    before = stated if wiring is None else stated.sampled_at(wiring.rate_hz, is_needed=is_integrated)

    def angles_with(proven: Sequence[Stretch] | None) -> AngleStream:
        return _angles_of(package, second, reading_sd_v, settings, before, gravity_mps2, geometry, wiring, proven)

    looked = LookedAfter(angles_with, package, second, reading_sd_v, stated, before)
    _note_all(_assumptions(package, looked, before, geometry, alignment, reading_sd_v))
    answers = Answers(out, view, plot, package.coefficients.sensor)
    throughout = answer_all(looked.found, looked.again(), data, wiring, for_s, answers)
    _note_all(_remarks_on_rows(package, looked, is_flagged_throughout=throughout))
    tell_unseen(package.coefficients.sensor, looked.angles, looked.found.rows, looked.packages, json=json)


def _note_all(remarks: Iterable[str]) -> None:
    for remark in remarks:
        note(remark)


def _assumptions(
    package: Package,
    looked: LookedAfter,
    before: OfSamples,
    geometry: Mapping[str, bool],
    alignment: Path | None,
    reading_sd_v: float | None,
) -> Iterator[str]:
    """Yield what the angles take for granted, a set that is not usable first."""
    angles, packages = looked.angles, looked.packages
    field = angles.field if isinstance(angles, AidedAngles) else None
    yield from _doubts_of_sets([*packages, *([] if field is None else [field.package])])
    if package.alignment is None:
        yield from _fixtures_axes(packages)
    yield from untested_temperature(packages)
    yield from untold_curvature(packages)
    yield from untested_shifts(packages)
    if isinstance(angles, GyroAngles | AidedAngles):
        rates = angles.package if isinstance(angles, GyroAngles) else angles.gyros
        yield from few_degrees_of_freedom([rates])
    if package.follows_sting:
        yield f"{package.coefficients.sensor}: a model package alone: yaw is taken as 0"
    elif len(package.columns) == 2 and not package.senses_rates:
        yield _which_of_two(package, upright=geometry["upright"], right_wing_down=geometry["right_wing_down"])
    if isinstance(looked.watched, StandingOutputs):
        yield assumed_gravity(package)
        yield from undetermined_terms(package)
    if package.alignment is not None and package.alignment.known_sd_rad is None:
        yield f"alignment: {alignment}: {TAKEN_AS_EXACT}"
    if reading_sd_v is None and (before.average_s, before.low_pass_hz) != (None, None) and not package.senses_rates:
        yield SD_OF_A_READING
    if isinstance(angles, GyroAngles):
        yield from assumed_of_gyros(angles)
    if isinstance(angles, AidedAngles):
        yield from assumed_of_filter(angles)


def _fixtures_axes(packages: Sequence[Package | GyroPackage]) -> Iterator[str]:
    """Yield of every package that sat turned on its fixture whose angles are told."""
    for coefficients in {used.coefficients.sha256: used.coefficients for used in packages}.values():
        said = mount_in_words(coefficients.document)
        if said is not None:
            yield (
                f"{coefficients.sensor}: {said}; of three axes --package-axes gives the package's own, --alignment a "
                "model's"
            )


def _doubts_of_sets(packages: Sequence[Package | GyroPackage]) -> Iterator[str]:
    """Yield of every set that is not usable that it is not, once, and of one that is dated in the future that it is."""
    sets = {used.coefficients.sha256: used.coefficients for used in packages}
    yield from (coefficients.doubt for coefficients in sets.values() if coefficients.doubt is not None)
    yield from (
        f"{used.sensor}: {DIRECTIONS_NOT_MEASURED}" for used in sets.values() if has_unmeasured_directions(used.axes)
    )
    yield from ahead_of_clock(sets.values(), datetime.now(UTC))


def _remarks_on_rows(package: Package, looked: LookedAfter, *, is_flagged_throughout: bool) -> Iterator[str]:
    """Yield what all rows say of the package that they were read from."""
    angles, watched = looked.angles, looked.watched
    yield from (f"{package.coefficients.sensor}: {doubt}" for doubt in looked.found.doubts())
    yield from rows_without_temperature(looked.packages, looked.found)
    if isinstance(angles, AidedAngles):
        yield angles.consistency()
    if isinstance(angles, GyroAngles | AidedAngles):
        yield from remarks_on_rest(angles)
    yield from (
        watched.doubts(is_flagged_throughout=is_flagged_throughout)
        if isinstance(watched, StandingOutputs)
        else doubts_of(angles, is_flagged_throughout=is_flagged_throughout)
    )


def _which_of_two(package: Package, *, upright: bool, right_wing_down: bool) -> str:
    """Say which of the two attitudes is told that two axes cannot tell apart."""
    axes = tuple(package.columns)
    if "x" not in axes:
        return (
            f"{package.coefficients.sensor}: without x the sign of pitch is not told: where a row is flagged as having "
            "a second attitude, which is nearly everywhere, its pitch may be of the other sign and its roll be wrong "
            "with it; measure x as well"
        )
    if set(axes) == {"x", "z"}:
        range_text, option = ("0° to 180°", "--no-") if right_wing_down else ("−180° to 0°", "--")
        other = f"{option}right-wing-down"
    else:
        range_text, option = ("within ±90°", "--no-") if upright else ("beyond ±90°", "--")
        other = f"{option}upright"
    return (
        f"{package.coefficients.sensor}: two axes ({', '.join(axes)}) have two answers to every row: roll {range_text} "
        f"is taken; a row on the other side is wrong in roll and pitch, and no flag can tell it; {other} takes "
        "that side"
    )


def _wiring(data: str | None, rig: Path | None, stream: str | None, for_s: float | None) -> StreamWiring | None:
    """Return the rig's stream where one is meant. Raises: RequestError where it is unclear where rows come from."""
    if (rig is None) != (stream is None):
        raise RequestError(
            "--rig and --stream belong together: the rig file, and which of its streams; nothing was read"
        )
    if (data is None) == (rig is None):
        raise RequestError("DATA, or --rig and --stream: give one of the two; nothing was read")
    if rig is None or stream is None:
        if for_s is not None:
            raise RequestError("--for: belongs to --stream; nothing was read")
        return None
    if for_s is not None and not for_s > 0.0:
        raise RequestError(f"--for {for_s:g}: got a time that is not above 0 s; nothing was read")
    return stream_wiring(rig, stream)


def _where_it_is_used(
    package: Package,
    gravity_mps2: float | None,
    gravity_uncertainty_mps2: float | None,
    alignment: Path | None,
    solve_alignment: Path | None,
) -> Package:
    """Return accelerometers with the g and the alignment of their use. Raises: RequestError for gyros that have one."""
    if not package.senses_rates:
        stored = package.alignment if alignment is None else load_alignment(alignment)
        return replace(used_at(package, gravity_mps2, gravity_uncertainty_mps2), alignment=stored)
    if alignment is not None or solve_alignment is not None:
        raise RequestError("--alignment, --solve-alignment: belong to accelerometers, got gyros")
    if gravity_uncertainty_mps2 is not None:
        raise RequestError("--gravity-uncertainty-mps2: belongs to accelerometers at rest, got gyros")
    return package


def _in_package_axes(package: Package, alignment: Path | None, solve_alignment: Path | None) -> Package:
    """Return accelerometers turned as their mount declares. Raises: RequestError, DesignError."""
    if alignment is not None or solve_alignment is not None:
        raise RequestError(
            "--package-axes: an alignment turns from the axes of the fixture: give one of the two; nothing was read"
        )
    if package.senses_rates:
        raise RequestError("--package-axes: belongs to accelerometers, got gyros; nothing was read")
    return replace(package, alignment=as_mounted(package.coefficients.sensor, package.coefficients.document))


def _angles_of(
    package: Package,
    second: Package | None,
    reading_sd_v: float | None,
    settings: OfGyros,
    before: OfSamples,
    gravity_mps2: float | None,
    geometry: Mapping[str, bool],
    wiring: StreamWiring | None,
    proven: Sequence[Stretch] | None,
) -> AngleStream:
    """Return what makes angles of the sets, with what was ``proven`` of the rows where they were read before.

    Raises: RequestError, OutsideValidity, SetError.
    """
    _refuse_idle_geometry(package, geometry)
    if not package.senses_rates:
        alone = inference(package, second, reading_sd_v, **geometry)
        found = monitored(watched_axes(alone, proven), package.model, settings, before.rate_hz, wiring)
        if settings.gyro_set is None:
            before.refuse_idle_rate()
        return found
    if settings.gyro_set is not None:
        raise RequestError("--gyro-set: stands beside accelerometers, got a set of gyros")
    if second is not None:
        raise RequestError("--model-set: belongs to a sting package of accelerometers, got a set of gyros")
    return angles_of_gyros(package, reading_sd_v, settings, before.rate_hz, gravity_mps2, wiring)


def _refuse_idle_geometry(package: Package, geometry: Mapping[str, bool]) -> None:
    """Refuse sides that this package has no two of, and intervals of gyros. Raises: RequestError."""
    axes = ", ".join(package.columns)
    if package.senses_rates and geometry["intervals"]:
        raise RequestError("--intervals: belongs to accelerometers, got gyros")
    pair = set(package.columns) if len(package.columns) == 2 and not package.senses_rates else set()
    if not geometry["upright"] and pair != {"x", "y"}:
        raise RequestError(f"--no-upright: belongs to a package of x and y, got {axes}; nothing was read")
    if not geometry["right_wing_down"] and pair != {"x", "z"}:
        raise RequestError(f"--no-right-wing-down: belongs to a package of x and z, got {axes}; nothing was read")
