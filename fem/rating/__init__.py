"""What a machine's designer asks of a bearing: ratings, stiffness, friction, stresses, from one scene.

elastic         equilibria of elastic rings over a pitch of the rollers
answers         every number with its unit, meaning and source; `rating`
report          the table that is printed, the JSON file, rating.html
ross            bearing coefficients for rotordynamics
figures         those of the page
"""
