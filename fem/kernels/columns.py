"""Places in a row of a sample, rows of contacts: names alone."""

# Columns of a row by the result file's names (`lagrange.columns`): numbers, then blocks of n_rollers; those of further
# bodies stand behind. work_load, work_gravity and work_drive are parts of work_external.
SCALARS = (
    "time", "inner_x", "inner_y", "inner_vx", "inner_vy", "inner_ax", "inner_ay",
    "energy_kinetic", "energy_elastic", "energy_contact", "work_load", "work_gravity", "work_drive",
    "work_dissipated", "work_damping_contact", "work_damping_bodies",
)  # fmt: skip
N_SCALARS = len(SCALARS)
(
    TIME, HUB_X, HUB_Y, HUB_VX, HUB_VY, HUB_AX, HUB_AY, KINETIC, ELASTIC, CONTACT, WORK_LOAD, WORK_GRAVITY, WORK_DRIVE,
    DISSIPATED, DAMPED_BY_CONTACTS, DAMPED_BY_BODIES,
) = range(N_SCALARS)  # fmt: skip
BLOCKS = (
    "roller_x", "roller_y", "roller_turn", "roller_spin", "inner_force", "outer_force", "roller_roller_force",
    "inner_traction", "outer_traction", "inner_damping_force", "outer_damping_force",
)  # fmt: skip
IN_EVERY_ROW = "surfaces", "damping"  # parts of a scene, but for sinkages, which follow from the others
X, Y, TURN, SPIN, FORCE, _, _, TRACTION, _, DAMPER_FORCE, _ = range(len(BLOCKS))  # forces by row of contacts

INNER, OUTER, ROLLER = range(3)  # rows of contacts: rollers on the inner and the outer raceway, roller j with j + 1
