"""The ideal bearing: the paper's Lagrangian model, stated and solved.

bearing       Material, Bearing, BallBearing, Operation: geometry, masses, operating point
kinematics    rolling without slip: shaft, cage, roller spin, ball-pass frequencies; angles (20)
laws          line-contact laws Q(δ) that need the roller's length alone: harris, palmgren, iso16281, braendlein
ball_contact  Hertz point contact (4)-(11): curvatures, δ*(F), K of a ball on a raceway
raceway_laws  laws that know the raceways: johnson (= tripp), houpert, teutsch_sauer; `contact_laws(name, bearing)`
cage          the cage as a rigid body; `cage_motion`: its samples in the Lagrangian model; `cage_steps`: its steps
faults        spalls, waviness, unequal rollers, measured heights: facts; `closing`: how far a roller sinks into them
film          a lubricant's film: how thick, on which raceway
contact_damping  dampers beside the contacts' springs
edges         how much softer contacts are at a spall's edges; `softened`: a law with a compliance in series
profile       surfaces as contacts meet them: sinkage and its slope, for all that knows the bearing
spall_passages  rollers over spalls, sample by sample; `spall_events`: their entry, strike and exit
pair          two circles in line contact: Hertz's half-width and pressure
overlap       geometry (19), (26), (27): how deep rollers lie in the raceways, and its derivatives
equations     the hub's equations (22), (23) over a record in Cartesian coordinates
energy        T and V: (2), (3), (14)-(17)
motion        the N_b + 2 equations (21)-(23), the θ equation, damping, accelerations; (21) as printed
statics       equilibrium of hub and rolling elements
load_ramp     a load that grows by half a cosine
problem       what is solved, with the model's choices; `first_state`: where it starts; `step_size`: how long steps
              may be; `near_faults`: when contacts are near faults, where they are shorter
systems       accelerations of hub and elements, with kinematic angles and with free ones
integrate     time stepping: Blanes and Moan's fourth-order scheme, leapfrog with damping
simulate      forward solution, at once or in parts that can be kept and gone on with; its refinement
trajectory    its result: motion, forces, energies, works
scene         the TOML scene file: validated, in the bearing engineer's units; gives the objects above in SI
scene_bearing its tables of the bearing; `scene_run`: of how it is run; `scene_surfaces`: [[spall]], [[waviness]] ...
scene_damping [damping]; `scene_lubricant`: [lubricant]
scene_cage    [cage]
scene_columns columns of tables made elsewhere; `catalogue`: standard bearings
course        speed and load that change: smooth functions of time; `scene_operation`: [operation] of the scene
scene_combinations  what tables can't be together; `scene_text`: TOML and --set as nested tables
scene_files   files that a scene names; `text_table`: columns of numbers in them; `height_table`: measured heights
scene_faults  what is wrong with a scene, all at once; `scene_keys`: what its keys mean
stored        numbers out of HDF5 files that may be damaged or hostile; `hdf5_writing`: HDF5 on a disk that may fail
output_files  files written whole, in no foreign file's place; `loading`: libraries without the user's settings
sealed        files of caches, known when they are damaged; `messages`: what commands print, always printable; `pages`:
              templates of HTML pages, and uPlot; `version`: the program's

Example, 5 ms of the paper's bearing:

    from lagrange import contact_laws, simulate
    from lagrange.scene import read_scene

    scene = read_scene()
    bearing = scene.ideal_bearing()
    run = simulate(bearing, scene.ideal_operation(), contact_laws("harris", bearing), 5e-3, 1e-5)

Everything but `scene` (which validates with pydantic) and `pages` (jinja) needs numpy and scipy only.
"""

from lagrange.bearing import BallBearing, Bearing, Material, Operation
from lagrange.kinematics import Kinematics, kinematics
from lagrange.raceway_laws import ContactLaws, contact_laws
from lagrange.simulate import simulate
from lagrange.statics import Statics, static_equilibrium
from lagrange.trajectory import Trajectory

__all__ = [
    "BallBearing",
    "Bearing",
    "ContactLaws",
    "Kinematics",
    "Material",
    "Operation",
    "Statics",
    "Trajectory",
    "contact_laws",
    "kinematics",
    "simulate",
    "static_equilibrium",
]
