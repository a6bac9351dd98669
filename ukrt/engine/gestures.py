"""The kinds of gesture a player can ask of a string; the numbers are shared by compiled code and Python.

A gesture is (frame, kind, string, p0..p4). What the parameters mean stands beside each kind.
"""

# p0 place/L, p1 peak force [N], p2 angle [rad], p3 ramp [frames], p4 note id; starts at frame, releases at frame + p3
PLUCK = 1
# p0 place of the stiff contact [m], p1 landing [frames], p2 speed [m/s]; without speed it lands at rest, or slides
# there if the finger is already down; with speed it hammers the string, in place of a finger that is down
PRESS = 2
# p1 ramp [frames], p2 pull [N], p3 its angle [rad]; without pull the stopping finger's mass, damping and stiffness fade
# together; with it the finger draws the string aside, as far as that force would, and then lets go at once
LIFT = 3
MOVE = 4  # p0 place [m], p1 duration [frames]: the stopping finger slides
DAMP = 5  # p0 share of the preset's damper, 0..1, p1 ramp [frames]: the damping finger comes down
UNDAMP = 6  # p1 ramp [frames]: the damping finger lifts
TENSION = 7  # p0 target tension / tension at rest, p1 ramp [frames], p2 0: eased at both ends, 1: straight
# p0 place/L, p1 ramp [frames], p2 resistance / sqrt(T mu), 0: away with it; damps at one place, instead of the damper
TOUCH = 8
RELEASE = 9  # p1 ramp [frames] in which plucks of the string let go from now on; 0 or 1: at once
