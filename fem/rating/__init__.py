"""What a machine's designer asks of a bearing: ratings, stiffness, friction, stresses, from one scene.

Read `answers` first: every number with its unit, meaning and source. `equilibria` of elastic rings and tilted rollers;
`report`: the table that is printed, the JSON file, rating.html with its `figures`; `ross`: coefficients for rotors.
"""
