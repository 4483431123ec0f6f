"""A run from a scene to a result file by whichever solver: checkpoints, signals, how it went, what is printed."""

import time
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fem.commands.start_up import Outcome, progress_display, stop_signals
from fem.quantities import run_summary
from fem.result import checkpoint
from fem.result.checkpoint import checkpoint_path, load_checkpoint, save_checkpoint
from fem.result.run_file import RunFile
from fem.result.store import ResultFile, Stored, WriteFailed, bytes_of_a_sample, write_estimates
from fem.solver.compiling import CompiledPlan, is_compiled, remember, seconds_by_trial
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Plan
from lagrange.bearing import is_plain, section_words
from lagrange.errors import RunFailed, UsageError
from lagrange.files.output import remove_left
from lagrange.kinematics import kinematics, mean_kinematics
from lagrange.messages import Section, engineering, print_section, said_if_long, say, shown, telling
from lagrange.mounting import from_outer_ring
from lagrange.scene.faults import RPM
from lagrange.scene.scene import Scene

CHECKPOINT_SECONDS = 10.0  # of wall time, unless given
CHECKPOINT_SHARE = 0.005  # of the wall time at most, unless given: a slow disk gets checkpoints less often
PATIENCE = 5.0  # s, of planning without a word
PLANNING = "planning: meshes, matrices, static equilibrium and critical step (a million nodes: one minute, 1.2 GB)"
GO_ON = "to continue: the same command with --resume"
LARGE_RESULT = 200.0  # MB, of which a run warns
LEAST_ERROR = 1e-5  # relative; less is the round-off of two solutions


class RunOptions(NamedTuple):
    """How a scene is to be run."""

    resume: bool = False
    quiet: bool = False
    estimate_error: bool = False
    checkpoint_seconds: float | None = None  # between checkpoints; None: CHECKPOINT_SECONDS, more on slow disks


def run_scene(scene: Scene, path: Path, options: RunOptions) -> Outcome:
    """Plan a scene, run it into a result file, and estimate its error where that is wished. UsageError: a solver can't
    take the scene or estimate its error; there is no place for a checkpoint, or none to resume from; as `simulate`."""
    began, tell = time.perf_counter(), None if options.quiet else say
    checkpoint.refuse_no_place(path)
    if options.resume:
        checkpoint.refuse_nothing_to_resume(path)
    if options.estimate_error:
        from fem.solver.errors import coarser_scene, error_estimate

        if scene.model == "fem":  # before the plan is made, which takes its time
            coarser_scene(scene)
    with said_if_long(PATIENCE, PLANNING, tell):
        plan = make_plan(scene)
    estimate = error_estimate(plan) if options.estimate_error else None
    plan.prepare(tell)
    for sentence in (*plan.notices, *(() if options.quiet else (*plan.warnings, *size_warning(plan)))):
        say(f"warning: {sentence}")
    outcome = simulate(plan, time.perf_counter() - began, path, options)
    if estimate is None or outcome is not Outcome.COMPLETE:
        return outcome
    # the coarser plan beside a finished run, and what its result may be off by
    with stop_signals() as stopped:
        try:
            with progress_display(estimate.coarse, options.quiet) as show:
                found = estimate.find(RunFile(path), show, lambda: bool(stopped))
        except (RunFailed, UsageError) as error:  # UsageError: of a static equilibrium that is not found
            return _ended(Outcome.ESTIMATE_FAILED, reason=error, path=path)
    if stopped:
        return _ended(Outcome.by(stopped, "ESTIMATE_"), path=path)
    write_estimates(path, found, estimate.mesh_size)
    rows = []
    for each in found:
        scale, unit = engineering(each.quantity.unit)
        relative = f"{100 * each.relative:.2g} %" if each.relative < 1.0 else "-"
        value, error = f"{scale * each.quantity.value:.5g} {unit}", f"{scale * each.error:.2g} {unit}"
        rows.append((each.quantity.meaning, value, error, relative))
    if not options.quiet:
        with telling():
            columns = "quantity", "value", "may be off by", "relative"
            print_section(Section(title=estimate.title, columns=columns, rows=rows))
    return Outcome.COMPLETE


def simulate(plan: Plan, setup_seconds: float, path: Path, options: RunOptions) -> Outcome:
    """Run a plan into a result file, with a checkpoint each so many seconds, unless given less often on slow disks.
    UsageError: there is nothing to resume, or not by this plan; the file is in use. OSError: it can't be written."""
    try:
        state, stored = load_checkpoint(path, plan) if options.resume else (plan.first_state(), None)
    except RunFailed as error:
        return _ended(Outcome.FAILED_AT_START, reason=error)
    outcome, reason, last = Outcome.COMPLETE, None, checkpoint_path(path)

    def left(in_place):  # what a run that ends early leaves
        if not in_place:
            return f"{store.committed} samples were in {path}, which has been moved or removed; put it back and {GO_ON}"
        how = GO_ON if last.is_file() else "it can't be resumed, no checkpoint could be saved"
        return f"{store.committed} samples are in {path}; {how}"

    attributes = state.outcome_attributes
    with stop_signals() as stopped, ResultFile(path, plan, setup_seconds, stored, **attributes) as store:
        try:
            if not options.resume:
                last.unlink(missing_ok=True)
            remove_left(last)
            saved, cost, every = time.monotonic(), 0.0, options.checkpoint_seconds

            def write(stored):  # the state of so many samples, or say that it can't be saved: the run goes on
                try:
                    save_checkpoint(path, state, stored)
                    return True
                except OSError as error:
                    say(f"warning: {error.filename}: {error.strerror}; no checkpoint was saved, the run goes on")
                    return False

            def save():
                nonlocal saved, cost
                began = time.monotonic()
                store.commit()
                write(store.stored)
                saved = time.monotonic()
                cost = saved - began

            def restart(reason):  # saved before its file restarts; what can't be gone on from is removed
                if not options.quiet:
                    say(reason)
                if not write(Stored()):
                    last.unlink(missing_ok=True)
                store.restart(**state.outcome_attributes)

            try:
                with progress_display(plan, options.quiet) as show:

                    def watch(progress):
                        with suppress(OSError):  # a terminal that has gone is no reason to stop
                            show(progress)
                        often = max(CHECKPOINT_SECONDS, cost / CHECKPOINT_SHARE) if every is None else every
                        if time.monotonic() - saved > often:
                            save()

                    run(plan, store.append, watch, lambda: bool(stopped), state, store.keep, restart)
                save()
                if stopped and state.done < plan.n_samples:
                    outcome = Outcome.by(stopped)
            except RunFailed as error:
                outcome, reason = Outcome.FAILED, error
            store.finish(outcome.status.format(reason=reason), **state.outcome_attributes)
        except WriteFailed as error:
            raise OSError(error.errno, f"{error.strerror}; {left(store.is_in_place)}", error.filename) from None
    for sentence in state.notices:
        say(f"warning: {sentence}")
    if outcome is Outcome.COMPLETE and not options.resume:
        remember(plan.scene.model, plan.expected_seconds, state.processor)
    if outcome is Outcome.COMPLETE and not options.quiet:
        with telling():
            _print_run(state, path)
    reached = 1e3 * state.progress.simulated
    return _ended(outcome, reason=reason, path=path, time=reached, left=left(True))


def _ended(outcome, **facts):
    if outcome.sentence:
        say(outcome.sentence.format(**facts))
    return outcome


# what is printed


def _print(lines):
    from rich.console import Console  # quiet runs do without

    for line in lines:
        Console(highlight=False).print(line, soft_wrap=True, markup=False)


def result_megabytes(plan: Plan) -> float:
    """Size of a plan's samples in the result file, without stored fields."""
    return 1e-6 * plan.n_samples * bytes_of_a_sample(plan.scene)


def size_warning(plan: Plan) -> tuple[str, ...]:
    """A warning of a large result file, or none."""
    size, numerics = result_megabytes(plan), plan.scene.numerics
    warning = (
        f"the result file takes {size:.3g} MB; to make it smaller, lower numerics.duration_ms = "
        f"{numerics.duration_ms:g}, or raise numerics.output_interval_us = {numerics.output_interval_us:g} if fast "
        "vibration does not matter"
    )
    return (warning,) if size > LARGE_RESULT else ()


def show_plan(scene: Scene, name: str) -> Outcome:
    """Plan a scene and print what is decided for a run of that name, and its cost. UsageError: a solver can't take the
    scene."""
    try:
        with said_if_long(PATIENCE, PLANNING, say):
            plan = make_plan(scene)
        table, rows, seconds = plan.table(), plan.rows(), seconds_by_trial(plan)
    except RunFailed as error:  # there is no equilibrium to tell of
        return _ended(Outcome.FAILED_AT_START, reason=error)
    from rich.console import Console

    if seconds is not None:
        rows["expected time"] = f"about {seconds:.2g} s (measured on a short piece)"
    rows["samples in the result file"] = f"{result_megabytes(plan):.3g} MB"
    if isinstance(plan, CompiledPlan):
        rows["compilation"] = "none, already cached" if is_compiled(plan) else plan.compiling
    Console(highlight=False).print(f"Plan of {shown(name)}, {plan.model_name}", style="italic", markup=False)
    if table is not None:
        Console(highlight=False).print(table)
    if (build_up := scene.operating_clearance()) is not None:
        print_section(
            Section(title="Diametral clearance", columns=("part", "µm", ""), rows=build_up.rows()), left=(0, 2)
        )
    _print(f"{name + ':':30s} {value}" for name, value in (_of_the_bearing(scene) | rows).items())
    # what each model takes for the scene, what it errs by and leaves out; what to begin with
    from fem.solver.errors import model_choices, suggestion  # only a dry run needs what these import

    choices, rows = model_choices(plan), []
    if (begin := suggestion(choices)) is not None:
        for each in choices:
            lasts = seconds if seconds is not None and each.model == plan.scene.model else each.seconds
            error = "-" if each.hub_error is None else f"below {100 * LEAST_ERROR:g} %"
            if each.hub_error is not None and each.hub_error > LEAST_ERROR:
                error = f"{100 * each.hub_error:.2g} %"
            rows.append((each.model, "-" if lasts is None else f"{lasts:.2g} s", error, each.lacks))
        columns = "model", "expected time", "static error of hub", "leaves out"
        print_section(Section(title="Models for this scene", columns=columns, rows=rows), left=(0, 3))
        _print([begin])
    _print(f"Warning: {sentence}" for sentence in (*plan.notices, *plan.warnings, *size_warning(plan)))
    return Outcome.COMPLETE


def _of_the_bearing(scene):  # what the scene alone decides and its file does not say
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()

    def lines(*speeds):
        found = kinematics(bearing, *speeds).frequencies
        return ", ".join(f"{name} {value:.4g} Hz" for name, value in found.items())

    clearance = round(2e6 * bearing.radial_clearance / bearing.cosine + 1e-9, 3) + 0.0
    rows = {} if scene.fit else {"diametral clearance": f"{clearance:.3f} µm"}
    if not is_plain(bearing):
        rows["plane section"] = section_words(bearing)
    if scene.assumed:
        rows["defaults"] = scene.assumed
    if operation.history is not None:
        rows["largest load"] = f"at most {operation.heaviest:.5g} N"
    if operation.varies_speed:
        inner, outer = operation.ring_speeds_met
        for name, speeds in (("shaft speed", inner), ("outer ring speed", outer)):
            if speeds.any():
                rows[name] = f"{speeds.min() / RPM:.6g} to {speeds.max() / RPM:.6g} rpm"
        at = [np.argmin(inner), np.argmax(inner)] if np.ptp(inner) else [np.argmin(outer), np.argmax(outer)]
        for speed, ring in {(float(inner[k]), float(outer[k])): None for k in at}:
            beside = f", outer ring {ring / RPM:.6g} rpm" if outer.any() else ""
            rows[f"frequencies at {speed / RPM:.6g} rpm{beside}"] = lines(speed, ring)
    elif operation.fastest:
        rows["frequencies, without slip"] = lines(*operation.ring_speeds)
    if scene.cage is not None:
        rows["cage"] = scene.cage.words + ("" if scene.is_given("cage") else "; the default")
    elif scene.model != "lagrange" or scene.lagrange.angles == "free":
        why = scene.default_cage()
        rows["cage"] = f"none{f' ({why})' if isinstance(why, str) else ''}: unloaded rollers coast"
    return rows


def show_meshes(scene: Scene, name: str) -> None:
    """Print statics on meshes, Richardson's values and those of the exact series."""
    from fem.solver.errors import mesh_table

    found = mesh_table(scene)
    quantities = found.meshes[0].quantities
    lines = [(f"{m.size:.3g}", str(m.nodes), [q.value for q in m.quantities]) for m in found.meshes]
    lines.append(("Richardson", "", found.extrapolated))
    if any(value is not None for value in found.exact):
        lines.append(("exact series", "", found.exact))
    rows, units = [], [engineering(quantity.unit) for quantity in quantities]
    for *first, values in lines:
        pairs = zip(values, units, strict=True)
        rows.append((*first, *("" if v is None else f"{factor * v:.6g} {unit}" for v, (factor, unit) in pairs)))
    columns = "mesh, mm", "nodes", *(quantity.meaning for quantity in quantities)
    with telling():
        print_section(Section(title=f"Statics of {name} by mesh", columns=columns, rows=rows), left=())


def _print_run(state, path):
    """Print the bearing's quantities from a run's file, and the file's place."""
    plan, progress, samples, scene = state.plan, state.progress, RunFile(path), state.plan.scene
    bearing = scene.ideal_bearing()
    if plan.n_samples == 1:  # places and forces of an equilibrium, and the speed of the centrifugal force in it
        inner, outer = (speed / RPM for speed in scene.ideal_operation().ring_speeds)
        speed = f" at {inner:g} rpm" + (f", outer ring {outer:g} rpm" if outer else "") + ", with centrifugal force"
        x, y = (round(1e6 * place[0], 4) + 0.0 for place in from_outer_ring(samples, "inner"))
        hub = f"Static equilibrium{speed if inner or outer else ' at rest'}: hub x {x:.4f} µm, y {y:.4f} µm"
        moved = [body for body in ("outer_ring", "housing") if f"{body}_y" in samples]
        hub += ", from the outer ring's centre" if moved else ""
        for body in moved:
            place = ", ".join(f"{axis} {1e6 * samples[f'{body}_{axis}'][0]:.4f} µm" for axis in "xy")
            hub += f"; {body.replace('_', ' ')} {place}"
        loaded = sorted(samples["inner_force"][0][samples["inner_force"][0] > 0.0], reverse=True)
        lines = [hub, f"Loaded rollers: {', '.join(f'{value:.1f}' for value in loaded) or 'none'} N"]
    else:
        ideal = mean_kinematics(bearing, scene.ideal_operation(), progress.simulated)
        found = run_summary(bearing, ideal, samples, tilts=scene.axial is not None)
        lines = [f"{name + ':':14s} {value}" for name, value in found.items()]
        lines.append(
            f"{1e3 * progress.simulated:g} ms in {progress.wall:.2f} s ({progress.steps} steps), energy imbalance "
            f"{progress.imbalance:+.1e} of the exchanged energy"
        )
    if words := section_words(bearing):
        lines.insert(0, f"plane section: {words}")
    if scene.assumed:
        lines.append(f"{'defaults:':14s} {scene.assumed}")
    lines += [f"Warning: {sentence}" for sentence in state.warnings]  # the plan's stand at the start
    _print([*lines, f"Result: {shown(path)}"])
