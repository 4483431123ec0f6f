"""The stated discretisation error: Richardson's extrapolation, bracketing the true one, in the result file."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
import xarray

from fem.commands.run_fem import run_main
from fem.errors import UsageError
from fem.quantities import Quantity, moving_quantities
from fem.solver.errors import SAFETY, coarser_scene, estimates
from fem.statics.equilibrium import static_quantities
from fem.statics.exact_statics import exact_statics
from lagrange.scene.scene import read_scene
from tests.reference.bearings import SHAPES, fair_load, model, operation


def quantity(value):
    return Quantity(name="q", unit="m", meaning="any", value=value)


@pytest.mark.parametrize("ratio", [1.5, 2.0, 3.0])
def test_the_error_of_a_second_order_sequence_is_found_up_to_the_factor_of_safety(ratio):
    exact, factor = 3.6, -0.4
    fine, coarse = (quantity(exact + factor * h**2) for h in (0.1, 0.1 * ratio))
    found = estimates([fine], [coarse], ratio)[0]
    assert found.error == pytest.approx(SAFETY * abs(fine.value - exact), rel=1e-12)
    assert found.relative == pytest.approx(found.error / 3.596, rel=1e-12)


def test_the_estimate_brackets_the_true_error_of_nine_bearings_in_ten():
    """Against the exact series; surface spacings of a fifth and two fifths of the rollers' radius."""
    bracketed = {}
    for name, bearing in SHAPES.items():
        how = operation(gravity=0.0, radial_load=fair_load(bearing))
        size = bearing.roller_radius / 5.0
        fine, coarse = (model(bearing, h) for h in (size, 2.0 * size))
        ratio = coarse.roller.shape.surface_spacing / fine.roller.shape.surface_spacing
        found = estimates(static_quantities(fine, how), static_quantities(coarse, how), ratio)
        exact = exact_statics(bearing, how.radial_load, how.first_roller_angle)
        true = {
            "static_hub_y": abs(found[1].quantity.value - exact.hub[1]),
            "static_largest_force": abs(found[2].quantity.value - exact.inner_force.max()),
        }
        round_off = {"static_hub_y": 1e-8 * abs(exact.hub[1]), "static_largest_force": 1e-8 * how.radial_load}
        bracketed[name] = all(
            each.error + round_off[each.quantity.name] >= true[each.quantity.name] for each in found[1:3]
        )
    assert len(bracketed) >= 10
    assert sum(bracketed.values()) >= 0.9 * len(bracketed), bracketed


def test_quantities_at_rest_are_those_of_the_whole_load():
    """A load that a pitch of the rollers has turned displaces the hub as far, a pitch further round."""
    how = operation(gravity=0.0, radial_load=2000.0)
    whole = model(SHAPES["paper"], 1e-3)
    pitch = 2.0 * np.pi / whole.bearing.n_rollers
    turned = replace(how, radial_load=2000.0 * np.cos(pitch), side_load=2000.0 * np.sin(pitch))
    down, aside = (complex(*(each.value for each in static_quantities(whole, loads)[:2])) for loads in (how, turned))
    assert aside == pytest.approx(down * np.exp(1j * pitch), rel=1e-3)


def test_moving_quantities_are_those_of_a_made_up_record():
    time = np.linspace(0.0, 1.0, 1001)
    wave = np.sin(2.0 * np.pi * 10.0 * time)
    angle = 3.0 * time[:, None] + np.arange(4)
    force = np.column_stack([100.0 + 5.0 * wave, 50.0 + 0.0 * time, 0.0 * time, 0.0 * time])
    record = {"time": time, "inner_x": 1e-8 * wave, "inner_y": -3e-6 + 2e-8 * wave, "inner_force": force}
    found = {each.name: each.value for each in moving_quantities({**record, "roller_theta": angle})}
    assert found["hub_mean_y"] == pytest.approx(-3e-6, rel=1e-9)
    assert found["hub_std_x"] == pytest.approx(1e-8 / np.sqrt(2.0), rel=1e-3)
    assert found["hub_std_y"] == pytest.approx(2e-8 / np.sqrt(2.0), rel=1e-3)
    assert found["largest_force"] == pytest.approx(105.0, rel=1e-4)
    assert found["mean_largest_force"] == pytest.approx(100.0, rel=1e-4)
    assert found["cage_speed"] == pytest.approx(3.0, rel=1e-12)


def test_a_mesh_that_leaves_no_coarser_one_is_refused(capsys, tmp_path):
    with pytest.raises(UsageError, match=r"mesh_size_mm = 2\.5"):
        coarser_scene(read_scene(None, ("numerics.mesh_size_mm=2.5",)))
    assert coarser_scene(read_scene()).numerics.mesh_size_mm == 2.0
    output = tmp_path / "no.nc"
    assert run_main(["--estimate-error", "--mesh-size", "3", "--output", str(output)]) == 2
    assert "--estimate-error" in capsys.readouterr().err and not output.exists()


def test_the_result_file_states_the_error_until_the_record_grows(tmp_path, capsys):
    path = tmp_path / "run.nc"
    options = ["--mesh-size", "1.9", "--output", str(path), "--duration"]
    assert run_main([*options, "0.3", "--estimate-error"]) == 0
    assert "may be off by" in capsys.readouterr().out
    with xarray.open_dataset(path) as data:
        names = data["quantity"].values.tolist()
        error, value = (data[name].values for name in ("quantity_error", "quantity_value"))
        assert data.attrs["coarse_mesh_size"] == pytest.approx(np.pi * 1e-3)
        hub = names.index("hub_mean_y")
        mean = np.trapezoid(data["inner_y"], data["time"]) / float(data["time"][-1] - data["time"][0])
        assert value[hub] == pytest.approx(mean, rel=1e-12)
        assert 1e-5 < error[hub] / abs(value[hub]) < 0.02
        assert np.all(error >= 0.0)
    assert run_main([*options, "0.4", "--resume"]) == 0
    with h5py.File(path) as file:
        assert "quantity" not in file and "coarse_mesh_size" not in file.attrs
