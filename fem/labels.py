"""What a run is an example of: the labels that its signals carry in a data set."""

from math import nan

from lagrange import kinematics
from lagrange.scene import Scene

OF_SPALL = {"angle_deg": "deg", "width_mm": "mm", "depth_um": "um"}  # units
UNITS = {
    "speed_rpm": "rpm",
    "radial_load_N": "N",
    **{f"{line}_Hz": "Hz" for line in ("shaft", "FTF", "BSF", "BPFO", "BPFI")},
    "spall_body": "1",
    **{f"spall_{key}": unit for key, unit in OF_SPALL.items()},
}


def labels(scene: Scene) -> dict[str, float | str]:
    """Speed, load, frequencies of rolling without slip, and the first spall: its body is "none" where there is none.

    NaN where a table changes them: no number of a run is its speed or its load then.
    """
    acting, operation, first = scene.ideal_operation(), scene.operation, scene.spall[0] if scene.spall else None
    lines = kinematics(scene.ideal_bearing(), nan if acting.varies_speed else acting.speed).frequencies
    return {
        "speed_rpm": operation.speed_rpm if operation.speed_table is None else nan,
        "radial_load_N": operation.radial_load_N if operation.load_table is None else nan,
        **{f"{name}_Hz": value for name, value in lines.items()},
        "spall_body": "none" if first is None else first.body,
        **{f"spall_{key}": nan if first is None else float(getattr(first, key)) for key in OF_SPALL},
    }
