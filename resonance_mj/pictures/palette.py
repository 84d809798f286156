"""The colours of figures and videos: Okabe and Ito's, told apart by colour-blind readers.

A colour means the same wherever it is seen, on paper as in a film.
"""

MEASURED = "#0072B2"
"""What was measured; the tool and its trail."""
OPTIMAL = "#D55E00"
"""With optimal springs; what fails."""
DESIRED = "#000000"
"""What is desired."""
MUTED = "#7F7F7F"
"""Without springs; remarks."""
NOTE = "#555555"
"""Small print."""
EARLY = "#56B4E9"
"""As `MEASURED`, at the beginning."""
MOTOR = "#AA3377"
"""The motors' torque beside the springs'."""
SPRING_NEGATIVE, SPRING_ZERO, SPRING_POSITIVE = "#E69F00", "#C4C4C4", "#009E73"
"""Springs of negative, no and positive stiffness."""

SERIES = (MEASURED, "#009E73", "#CC79A7", "#E69F00", EARLY, DESIRED, "#F0E442")
"""One colour each for joints or runs, without that of the optimum and of what fails."""
