"""What measures speed, each a command that prints a table; run from the checkout's root. Correctness: `tests`.

throughput      time of every phase of a step against the machine's ceilings
phases          the phases of a step, timed, and the work they need at least
machine         the ceilings, measured
skips           what a scene does not need it does not pay for; `table_costs`: what tables of it cost
footprint       memory and start-up time of a process
planning        what it takes to plan a scene after others
studies         what a study adds to its points, and what a second worker gives
checkpoint_cost what checkpoints and commits cost, as paired ratios
work_precision  run time against error over meshes
lagrange_model  the Lagrangian model solved: its time, its energy, the checker on its own output
live            frames a second of the live page, and what they take
pictures        docs' pictures; stress below contacts, times, sizes
same_bits       whether another revision gives the same bits, and takes the same time

measuring       what they share: scenes with some keys set, times, runs in turns, tables
"""
