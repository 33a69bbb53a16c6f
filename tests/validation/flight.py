"""Check cases of the NASA Engineering and Safety Center for programs of flight in six degrees of freedom.

A rigid body flies freely near an oblate Earth that rotates. Gravity with J2, drag and damping are loads. The
cases and their constants are those of github.com/nasa/simupy-flight, nesc_test_cases.
"""

import axode
import numpy as np
from comparison import Comparison, Published, Scheme

FOOT, SLUG = 0.3048, 14.59390294  # m, kg
GM, J2 = 3.986004418e14, 0.00108262982  # m^3/s^2
A, F = 6378137.0, 1 / 298.257223563  # WGS 84: equatorial radius, m, and flattening
E2 = F * (2 - F)
EARTH = np.array([0, 0, np.radians(0.004178073)])  # rate of rotation, rad/s


def gravity(p):
    """Acceleration by the central field and J2, m/s^2: the gradient of GM/r (1 - J2 (A/r)^2 P_2(z/r))."""
    r = np.linalg.norm(p)
    return -GM * p / r**3 * (1 + 1.5 * J2 * (A / r)**2 * (np.array([1, 1, 3]) - 5 * (p[2] / r)**2))


def geodetic(p):
    """Latitude (rad) and height (m) above the ellipsoid."""
    rho, latitude = np.hypot(p[0], p[1]), np.arctan2(p[2], np.hypot(p[0], p[1]) * (1 - E2))
    for _ in range(10):
        N = A / np.sqrt(1 - E2 * np.sin(latitude)**2)
        latitude = np.arctan2(p[2] + E2 * N * np.sin(latitude), rho)
    return latitude, rho * np.cos(latitude) + p[2] * np.sin(latitude) - A**2 / N


def air_density(height):
    """Density below 11 km, kg/m^3: U.S. Standard Atmosphere 1976, equations 18, 23, 33a and 42."""
    H = 6356766 * height / (6356766 + height)  # geopotential height
    T = 288.15 - 0.0065 * H
    M, R = 0.0289644, 8.31432  # kg/mol, N m/(mol K)
    return 101325 * (T / 288.15)**(9.80665 * M / (R * 0.0065)) * M / (R * T)


def local_axes(longitude, latitude):
    """North, east and down as columns."""
    sin_l, cos_l, sin_b, cos_b = np.sin(longitude), np.cos(longitude), np.sin(latitude), np.cos(latitude)
    return np.array([[-sin_b * cos_l, -sin_l, -cos_b * cos_l], [-sin_b * sin_l, cos_l, -cos_b * sin_l],
                     [cos_b, 0, -sin_b]])


def fly(scheme, mass, inertia, height, velocity, rates, air=None):
    """State after 30 s, by the names and in the units of the check cases.

    The flight begins over latitude and longitude 0 with the axes of the body to the north, east and down.
    `velocity` (m/s) is relative to the Earth, `rates` (rad/s) are inertial, both in these axes. The wrench
    `air(rates, earth, V, height)` depends on the inertial rates of the body and of the Earth and on the
    velocity V relative to the air, all in the axes of the body.
    """
    b = axode.Builder("flight", [0, 0, 0])
    m = b.body("body", joint="free", mass=mass, com=[0, 0, 0], inertia=inertia).build()
    R, p = local_axes(0, 0), np.array([A + height, 0, 0])
    q = np.append([0, -np.sqrt(0.5), 0, np.sqrt(0.5)], p)  # R as a quaternion: a quarter turn about -y
    v = np.append(rates, R.T @ np.cross(EARTH, p) + velocity)

    def loads(t, q, v):
        p, R = q[4:], axode.poses(m, q)[m.frame_index("body"), :3, :3]
        wrench = np.append(np.zeros(3), mass * R.T @ gravity(p))
        if air:
            wrench += air(v[:3], R.T @ EARTH, v[3:] - R.T @ np.cross(EARTH, p), geodetic(p)[1])
        return [axode.Load(frame="body", wrench=wrench)]

    q, v = scheme.states(m, q, v, [30], loads=loads)
    return observed(q[0, 4:], axode.poses(m, q[0])[m.frame_index("body"), :3, :3], v[0], 30)


def observed(p, R, v, t):
    """Quantities of the check cases at time t from the position, the orientation and the body-fixed twist."""
    longitude = np.arctan2(p[1], p[0])  # in inertial axes
    latitude, height = geodetic(p)
    local = local_axes(longitude, latitude)
    velocity = local.T @ (R @ v[3:] - np.cross(EARTH, p)) / FOOT
    attitude = local.T @ R
    angles = {"Yaw": np.arctan2(attitude[1, 0], attitude[0, 0]), "Pitch": -np.arcsin(attitude[2, 0]),
              "Roll": np.arctan2(attitude[2, 1], attitude[2, 2])}
    found = {"altitudeMsl_ft": height / FOOT, "latitude_deg": np.degrees(latitude),
             "longitude_deg": np.degrees(longitude - EARTH[2] * t)}
    found |= {f"feVelocity_ft_s_{axis}": speed for axis, speed in zip("XYZ", velocity)}
    found |= {f"eulerAngle_deg_{name}": np.degrees(angle) for name, angle in angles.items()}
    found |= {f"bodyAngularRateWrtEi_deg_s_{axis}": np.degrees(rate)
              for axis, rate in zip(("Roll", "Pitch", "Yaw"), v)}
    return found


HEIGHT = "height, ft", ["altitudeMsl_ft"]
PLACE = "latitude and longitude, °", ["latitude_deg", "longitude_deg"]
VELOCITY = "velocity to the north, east and down, ft/s", [f"feVelocity_ft_s_{axis}" for axis in "XYZ"]
AXES = "Roll", "Pitch", "Yaw"
RATES = "three angular rates, °/s", [f"bodyAngularRateWrtEi_deg_s_{axis}" for axis in AXES]
ANGLES = "three Euler angles, °", [f"eulerAngle_deg_{axis}" for axis in AXES]
PRECISE = Scheme(rtol=1e-12)


def compared(case, simulation, state, bounds, note=""):
    """A state at 30 s beside that of one simulation, for (quantity, bound)."""
    published = Published("nesc.json", case)
    row = next(row for row in published.rows if row[0] == simulation)
    for (quantity, names), bound in bounds:
        yield Comparison(f"{quantity} at 30 s", [state[name] for name in names],
                         [row[published.columns.index(name)] for name in names], bound, PRECISE,
                         f"{published.source} The reference is {simulation}.{note}")


def dropped_sphere():
    state = fly(PRECISE, SLUG, [1, 1, 1], 30000 * FOOT, np.zeros(3), np.zeros(3))
    yield from compared("nesc_01", "sim_04", state, [(HEIGHT, 1e-4), (PLACE, 1e-9), (VELOCITY, 1e-5)])


def brick(air=None):
    inertia = np.array([0.001894220, 0.006211019, 0.007194665]) * SLUG * FOOT**2
    return fly(PRECISE, 0.155404754 * SLUG, inertia, 30000 * FOOT, np.zeros(3), np.radians([10, 20, 30]), air)


def tumbling_brick():
    yield from compared("nesc_02", "sim_04", brick(), [(HEIGHT, 1e-4), (RATES, 1e-8), (ANGLES, 1e-6)])


def damped_brick():
    area, lengths = 0.22222 * FOOT**2, np.array([1, 2, 1]) / 3 * FOOT

    def damping(rates, earth, V, height):
        """Moments with the coefficient -1 for each rate relative to the air, times length / (2 V)."""
        moments = -air_density(height) * np.linalg.norm(V) * area / 4 * lengths**2 * (rates - earth)
        return np.append(moments, np.zeros(3))

    note = (" There and here rates are relative to the air, which rotates with the Earth; sim_01, sim_02 and"
            " sim_04 take inertial rates.")
    bounds = [(HEIGHT, 1e-4), (RATES, 1e-6), (ANGLES, 1e-2)]
    yield from compared("nesc_03", "sim_05", brick(damping), bounds, note)


def northward_cannonball():
    area, coefficient = 0.1963495 * FOOT**2, 0.1

    def drag(rates, earth, V, height):
        return np.append(np.zeros(3), -air_density(height) / 2 * np.linalg.norm(V) * area * coefficient * V)

    state = fly(PRECISE, SLUG, 3.6 * SLUG * FOOT**2 * np.ones(3), 0, np.array([1000, 0, -1000]) * FOOT,
                [EARTH[2], 0, 0], drag)
    yield from compared("nesc_10", "sim_04", state, [(HEIGHT, 1e-2), (PLACE, 1e-7), (VELOCITY, 1e-3)])


CASES = {"nesc_01": dropped_sphere, "nesc_02": tumbling_brick, "nesc_03": damped_brick,
         "nesc_10": northward_cannonball}
