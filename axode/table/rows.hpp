// The rows of the table of functions of a state: AXODE_ROW(name of the function in C++, members of Words...).
// Whoever includes this file defines AXODE_ROW first. functions.hpp makes the table of the rows, and
// catalog/functions.cpp calls the functions that they name.

// clang-format off
AXODE_ROW(poses, .purpose = "The poses C of all frames say where these are in the inertial frame.",
          .units = "m", .takes = {q}, .choice = none, .entry = pose, .shape = {n_frames}, .columns = false,
          .symbols = {"C"}, .together = "C", .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = false, .lanes = true, .tape = true, .counts = of_motion)
AXODE_ROW(pose, .purpose = "The pose C of one frame says where it is in the inertial frame.", .units = "m",
          .takes = {q, place}, .choice = none, .entry = pose, .shape = {}, .columns = false, .symbols = {"C"},
          .together = "C", .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
          .lanes = false, .tape = true, .counts = of_motion)
AXODE_ROW(twists, .purpose = "The twists V are the angular and linear velocities of all frames.",
          .units = screws, .takes = {q, v}, .choice = representation, .entry = twist, .shape = {n_frames},
          .columns = false, .symbols = {"V"}, .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = false, .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(accelerations, .purpose = "The rates V' are the time derivatives of the components of the twists "
              "of all frames, without gravity.", .units = rates, .takes = {q, v, a}, .choice = representation,
          .entry = rate, .shape = {n_frames}, .columns = false, .symbols = {"V'"}, .cost = linear,
          .allocates = false, .memory = may_share, .may_fail = false, .lanes = false, .tape = false,
          .counts = of_motion)
AXODE_ROW(jacobian, .purpose = "The Jacobian J of one frame maps velocities to its twist V = J v, and has a "
              "column for each velocity.", .units = "rad/s, m/s per unit of the velocity",
          .takes = {q, place}, .choice = representation, .entry = twist, .shape = {nv}, .columns = true,
          .symbols = {"J"}, .together = "J", .cost = linear, .allocates = false, .memory = own,
          .may_fail = false, .lanes = false, .tape = true, .counts = of_columns)
AXODE_ROW(jacobians, .purpose = "The Jacobians J of all frames map velocities to their twists V = J v, and "
              "have a column for each velocity.", .units = "rad/s, m/s per unit of the velocity",
          .takes = {q}, .choice = representation, .entry = twist, .shape = {n_frames, nv}, .columns = true,
          .symbols = {"J"}, .cost = quadratic, .allocates = false, .memory = own, .may_fail = false,
          .lanes = false, .tape = false, .counts = of_columns)
AXODE_ROW(jacobian_rate, .purpose = "The rate J' is the time derivative of the Jacobian of a frame.",
          .units = "rad/s^2, m/s^2 per unit of the velocity", .takes = {q, v, place},
          .choice = representation, .entry = rate, .shape = {nv}, .columns = true, .symbols = {"J'"},
          .cost = linear, .allocates = true, .memory = own, .may_fail = false, .lanes = false, .tape = false,
          .counts = of_columns)
AXODE_ROW(relative_jacobian, .purpose = "The relative Jacobian J maps velocities to the twist V = J v of a "
              "frame that an observer in another frame sees.", .units = "rad/s, m/s per unit of the velocity",
          .takes = {q, place, base}, .choice = representation, .entry = twist, .shape = {nv}, .columns = true,
          .symbols = {"J"}, .cost = linear, .allocates = false, .memory = own, .may_fail = false,
          .lanes = false, .tape = false, .counts = of_columns)
AXODE_ROW(joint_screws, .purpose = "The columns of J are the instantaneous joint screws, in inertial axes "
              "about the inertial origin.", .units = "rad/s, m/s per unit of the velocity", .takes = {q},
          .choice = none, .entry = twist, .shape = {n_screws}, .columns = true, .symbols = {"J"},
          .together = "J", .cost = linear, .allocates = false, .memory = own, .may_fail = false,
          .lanes = true, .tape = false, .counts = of_columns)
AXODE_ROW(center_of_mass, .purpose = "The point c is the centre of mass of all moving bodies, in the "
              "inertial frame.", .units = "m", .takes = {q}, .choice = none, .entry = vector, .shape = {},
          .columns = false, .symbols = {"c"}, .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = false, .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(center_of_mass_jacobian, .purpose = "The Jacobian J maps velocities to the velocity c' = J v of "
              "the centre of mass of all moving bodies, in inertial axes.",
          .units = "m/s per unit of the velocity", .takes = {q}, .choice = none, .entry = vector,
          .shape = {nv}, .columns = true, .symbols = {"J"}, .cost = linear, .allocates = false,
          .memory = may_share, .may_fail = false, .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(centroidal_momentum_matrix, .purpose = "The matrix A maps velocities to the momentum A v of the "
              "mechanism about its centre of mass, in inertial axes.", .units = inertias, .takes = {q},
          .choice = none, .entry = momentum, .shape = {nv}, .columns = true, .symbols = {"A"}, .cost = linear,
          .allocates = false, .memory = may_share, .may_fail = false, .lanes = false, .tape = false,
          .counts = of_motion)
AXODE_ROW(centroidal_momentum_matrix_rate, .purpose = "The rate A' is the time derivative of the centroidal "
              "momentum matrix A.", .units = "kg m^2/s, kg m/s, kg/s", .takes = {q, v}, .choice = none,
          .entry = wrench, .shape = {nv}, .columns = true, .symbols = {"A'"}, .cost = linear,
          .allocates = false, .memory = may_share, .may_fail = false, .lanes = false, .tape = false,
          .counts = of_motion)
AXODE_ROW(inverse_dynamics, .purpose = "The drive forces tau make the accelerations a.", .units = forces,
          .takes = {q, v, a, loads}, .choice = recursion, .entry = number, .shape = {nv}, .columns = false,
          .symbols = {"tau"}, .together = "tau", .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = false, .lanes = true, .tape = true, .counts = of_forces)
AXODE_ROW(forward_dynamics, .purpose = "The accelerations a are those that the drive forces tau make.",
          .units = rates, .takes = {q, v, tau, loads}, .choice = recursion, .entry = number, .shape = {nv},
          .columns = false, .symbols = {"a"}, .together = "a", .cost = linear, .allocates = false,
          .memory = may_share, .may_fail = true, .lanes = true, .tape = true, .counts = of_accelerations)
AXODE_ROW(joint_wrenches, .purpose = "Each joint transmits a wrench W to its body, from its drive and its "
              "constraints together.", .units = wrenches, .takes = {q, v, a, loads, at},
          .choice = representation, .entry = wrench, .shape = {n_joints}, .columns = false, .symbols = {"W"},
          .cost = linear, .allocates = false, .memory = may_share, .may_fail = false, .lanes = false,
          .tape = false, .counts = of_wrenches)
AXODE_ROW(mass_matrix, .purpose = "The mass matrix M gives the kinetic energy v^T M v / 2, and includes "
              "armatures.", .units = inertias, .takes = {q}, .choice = recursion, .entry = number,
          .shape = {nv, nv}, .columns = false, .symbols = {"M"}, .together = "M", .cost = quadratic,
          .allocates = false, .memory = may_share, .may_fail = false, .lanes = true, .tape = true,
          .counts = of_terms)
AXODE_ROW(inverse_mass_matrix, .purpose = "The matrix M^-1 is the inverse of the mass matrix.",
          .units = "1/(kg m^2), 1/(kg m), 1/kg", .takes = {q}, .choice = recursion, .entry = number,
          .shape = {nv, nv}, .columns = false, .symbols = {"M^-1"}, .together = "M_inverse",
          .cost = quadratic, .allocates = false, .memory = may_share, .may_fail = true, .lanes = true,
          .tape = true, .counts = of_terms)
AXODE_ROW(mass_matrix_partials, .purpose = "The matrices dM are the partial derivatives of the mass matrix, "
              "one for each direction of the configuration.", .units = "kg m^2, kg m, kg, kg/m", .takes = {q},
          .choice = none, .entry = number, .shape = {nv, nv, nv}, .columns = false, .symbols = {"dM"},
          .cost = cubic, .allocates = false, .memory = may_share, .may_fail = false,
          .derivative_of = "mass_matrix", .lanes = false, .tape = false, .counts = of_terms)
AXODE_ROW(inverse_mass_matrix_partials, .purpose = "The matrices dM^-1 are the partial derivatives of the "
              "inverse of the mass matrix, one for each direction of the configuration.",
          .units = "1/(kg m^2), 1/(kg m), 1/kg per unit of the direction", .takes = {q}, .choice = none,
          .entry = number, .shape = {nv, nv, nv}, .columns = false, .symbols = {"dM^-1"}, .cost = cubic,
          .allocates = true, .memory = own, .may_fail = true, .derivative_of = "inverse_mass_matrix",
          .lanes = false, .tape = false, .counts = of_terms)
AXODE_ROW(coriolis_matrix, .purpose = "The Coriolis matrix C(q, v), in the form that the caller chooses, "
              "gives the Coriolis and centrifugal forces C v.", .units = "kg m^2/s, kg m/s, kg/s",
          .takes = {q, v, form}, .choice = none, .entry = number, .shape = {nv, nv}, .columns = false,
          .symbols = {"C"}, .cost = quadratic, .allocates = false, .memory = may_share, .may_fail = false,
          .lanes = false, .tape = false, .counts = of_terms)
AXODE_ROW(coriolis_vector, .purpose = "The vector C v has the Coriolis and centrifugal forces of the "
              "motion.", .units = forces, .takes = {q, v}, .choice = recursion, .entry = number,
          .shape = {nv}, .columns = false, .symbols = {"C v"}, .cost = linear, .allocates = false,
          .memory = may_share, .may_fail = false, .lanes = false, .tape = false, .counts = of_terms)
AXODE_ROW(gravity_torques, .purpose = "The generalised forces g hold the tree at rest against gravity.",
          .units = forces, .takes = {q}, .choice = recursion, .entry = number, .shape = {nv},
          .columns = false, .symbols = {"g"}, .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = false, .lanes = false, .tape = false, .counts = of_gravity)
AXODE_ROW(generalized_loads, .purpose = "The generalised forces Q have the same power as the loads at any "
              "velocities.", .units = forces, .takes = {q, v, loads}, .choice = recursion, .entry = number,
          .shape = {nv}, .columns = false, .symbols = {"Q"}, .cost = linear, .allocates = false,
          .memory = may_share, .may_fail = false, .lanes = false, .tape = false, .counts = of_loads)
AXODE_ROW(christoffel, .purpose = "The numbers Gamma_ijk are the Christoffel symbols of the first kind, a "
              "matrix over (j, k) for each i.", .units = "kg m^2, kg m, kg, kg/m", .takes = {q},
          .choice = none, .entry = number, .shape = {nv, nv, nv}, .columns = false, .symbols = {"Gamma"},
          .cost = cubic, .allocates = false, .memory = may_share, .may_fail = false, .lanes = false,
          .tape = false, .counts = of_terms)
AXODE_ROW(kinetic_energy, .purpose = "The kinetic energy T counts all bodies and armatures.", .units = "J",
          .takes = {q, v}, .choice = none, .entry = number, .shape = {}, .columns = false, .symbols = {"T"},
          .cost = linear, .allocates = false, .memory = may_share, .may_fail = false, .lanes = false,
          .tape = false, .counts = of_motion)
AXODE_ROW(potential_energy, .purpose = "The potential energy U is that of gravity, and is 0 at the inertial "
              "origin.", .units = "J", .takes = {q}, .choice = none, .entry = number, .shape = {},
          .columns = false, .symbols = {"U"}, .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = false, .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(spring_forces, .purpose = "The generalised forces tau are those of springs, dampers and stops, "
              "which act in simulations.", .units = forces, .takes = {q, v}, .choice = none, .entry = number,
          .shape = {nv}, .columns = false, .symbols = {"tau"}, .cost = linear, .allocates = false,
          .memory = own, .may_fail = false, .lanes = false, .tape = false, .counts = of_springs)
AXODE_ROW(elastic_energy, .purpose = "The elastic energy U is stored in springs and stops.", .units = "J",
          .takes = {q}, .choice = none, .entry = number, .shape = {}, .columns = false, .symbols = {"U"},
          .cost = linear, .allocates = false, .memory = may_share, .may_fail = false, .lanes = false,
          .tape = false, .counts = of_springs)
AXODE_ROW(load_powers, .purpose = "The power of each load is the work that it does per second.", .units = "W",
          .takes = {q, v, loads}, .choice = none, .entry = number, .shape = {n_loads}, .columns = false,
          .symbols = {"power"}, .cost = linear, .allocates = false, .memory = own, .may_fail = false,
          .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(centroidal_inertia, .purpose = "The inertia M has the mass of the whole mechanism, and its "
              "rotational inertia about its centre of mass, in inertial axes.", .units = "kg, kg m, kg m^2",
          .takes = {q}, .choice = none, .entry = inertia, .shape = {}, .columns = false, .symbols = {"M"},
          .cost = linear, .allocates = false, .memory = may_share, .may_fail = false, .lanes = false,
          .tape = false, .counts = of_motion)
AXODE_ROW(impulse_response, .purpose = "The matrix Y = M^-1 J^T has a column for each velocity, with its "
              "jumps for unit impulses on a frame.", .units = "rad/s, m/s per N m s, N s",
          .takes = {q, place}, .choice = representation, .entry = twist, .shape = {nv}, .columns = true,
          .symbols = {"Y"}, .cost = linear, .allocates = false, .memory = own, .may_fail = true,
          .lanes = false, .tape = false, .counts = of_impulses)
AXODE_ROW(inverse_operational_space_inertia, .purpose = "The matrix J M^-1 J^T maps an impulse on a frame "
              "to the twist that the frame gets.", .units = "rad/s, m/s per N m s, N s", .takes = {q, place},
          .choice = representation, .entry = twist, .shape = {six}, .columns = true,
          .symbols = {"J M^-1 J^T"}, .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = true, .lanes = false, .tape = false, .counts = of_impulses)
AXODE_ROW(operational_space_inertia, .purpose = "The matrix Lambda = (J M^-1 J^T)^-1 is the inertia that a "
              "frame shows to a wrench; it is undefined if the frame cannot move in all six directions.",
          .units = inertias, .takes = {q, place}, .choice = representation, .entry = momentum, .shape = {six},
          .columns = true, .symbols = {"Lambda"}, .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = true, .lanes = false, .tape = false, .counts = of_impulses)
AXODE_ROW(regressor, .purpose = "The regressor Y of inverse dynamics satisfies Y pi = M a + C v + g, with "
              "ten inertial parameters pi for each body.", .units = "N m, N per unit of the parameter",
          .takes = {q, v, a}, .choice = none, .entry = number, .shape = {nv, n_parameters}, .columns = false,
          .symbols = {"Y"}, .cost = quadratic, .allocates = false, .memory = may_share, .may_fail = false,
          .lanes = false, .tape = false, .counts = of_terms)
AXODE_ROW(kinetic_energy_regressor, .purpose = "The regressor y of the kinetic energy of the bodies "
              "satisfies T = y pi, with ten inertial parameters pi for each body.",
          .units = "J per unit of the parameter", .takes = {q, v}, .choice = none, .entry = number,
          .shape = {n_parameters}, .columns = false, .symbols = {"y"}, .cost = linear, .allocates = false,
          .memory = may_share, .may_fail = false, .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(potential_energy_regressor, .purpose = "The regressor y of the potential energy satisfies U = y "
              "pi, with ten inertial parameters pi for each body.", .units = "J per unit of the parameter",
          .takes = {q}, .choice = none, .entry = number, .shape = {n_parameters}, .columns = false,
          .symbols = {"y"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
          .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(momenta, .purpose = "The generalised momenta p = M v follow from the velocities v.",
          .units = impulses, .takes = {q, v}, .choice = none, .entry = number, .shape = {nv},
          .columns = false, .symbols = {"p"}, .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = false, .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(from_momenta, .purpose = "The velocities v = M^-1 p follow from the generalised momenta p.",
          .units = screws, .takes = {q, p}, .choice = none, .entry = number, .shape = {nv}, .columns = false,
          .symbols = {"v"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = true,
          .lanes = false, .tape = false, .counts = of_terms)
AXODE_ROW(momentum_form, .purpose = "The rates of the state (q, p) under the drive forces tau are the "
              "velocities v and the rates dp of the momenta.", .units = "rad/s, m/s; N m, N",
          .takes = {q, p, tau, loads}, .choice = none, .entry = number, .shape = {nv}, .columns = false,
          .symbols = {"v", "dp"}, .cost = linear, .allocates = false, .memory = may_share, .may_fail = true,
          .lanes = false, .tape = false, .counts = of_momentum_form)
AXODE_ROW(body_momenta, .purpose = "The momenta Pi of the bodies are M V for the inertia M and the twist V "
              "of each body in its frame.", .units = impulses, .takes = {q, v}, .choice = representation,
          .entry = momentum, .shape = {n_bodies}, .columns = false, .symbols = {"Pi"}, .cost = linear,
          .allocates = false, .memory = may_share, .may_fail = false, .lanes = false, .tape = false,
          .counts = of_motion)
AXODE_ROW(spatial_momentum, .purpose = "The momentum Pi is that of the whole mechanism about the inertial "
              "origin.", .units = impulses, .takes = {q, v}, .choice = none, .entry = momentum, .shape = {},
          .columns = false, .symbols = {"Pi"}, .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = false, .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(centroidal_momentum, .purpose = "The momentum Pi is that of the whole mechanism about its centre "
              "of mass, in inertial axes.", .units = impulses, .takes = {q, v}, .choice = none,
          .entry = momentum, .shape = {}, .columns = false, .symbols = {"Pi"}, .cost = linear,
          .allocates = false, .memory = may_share, .may_fail = false, .lanes = false, .tape = false,
          .counts = of_motion)
AXODE_ROW(inverse_dynamics_derivatives, .purpose = "The matrices dtau/dq, dtau/dv and dtau/da are the "
              "partial derivatives of the drive forces of inverse_dynamics.",
          .units = "of tau per unit of the direction", .takes = {q, v, a, loads}, .choice = none,
          .entry = number, .shape = {nv, nv}, .columns = false, .symbols = {"dtau/dq", "dtau/dv", "dtau/da"},
          .together = "dtau", .cost = quadratic, .allocates = false, .memory = may_share, .may_fail = false,
          .derivative_of = "inverse_dynamics", .lanes = true, .tape = true,
          .counts = of_derivatives_of_forces)
AXODE_ROW(forward_dynamics_derivatives, .purpose = "The matrices da/dq, da/dv and da/dtau are the partial "
              "derivatives of the accelerations of forward_dynamics.",
          .units = "of a per unit of the direction", .takes = {q, v, tau, loads}, .choice = none,
          .entry = number, .shape = {nv, nv}, .columns = false, .symbols = {"da/dq", "da/dv", "da/dtau"},
          .together = "da", .cost = quadratic, .allocates = false, .memory = may_share, .may_fail = true,
          .derivative_of = "forward_dynamics", .lanes = true, .tape = true,
          .counts = of_variations_of_accelerations)
AXODE_ROW(momentum_form_derivatives, .purpose = "The matrices dv/dq, dv/dp, dp'/dq and dp'/dp are the "
              "partial derivatives of the velocities and rates of momentum_form.",
          .units = "of v and p' per unit of the direction", .takes = {q, p, loads}, .choice = none,
          .entry = number, .shape = {nv, nv}, .columns = false,
          .symbols = {"dv/dq", "dv/dp", "dp'/dq", "dp'/dp"}, .cost = quadratic, .allocates = false,
          .memory = own, .may_fail = true, .derivative_of = "momentum_form", .lanes = false, .tape = false,
          .counts = of_momentum_form)
AXODE_ROW(gravity_derivatives, .purpose = "The matrix dg/dq has the partial derivatives of the forces of "
              "gravity_torques.", .units = "of g per unit of the direction", .takes = {q}, .choice = none,
          .entry = number, .shape = {nv, nv}, .columns = false, .symbols = {"dg/dq"}, .cost = quadratic,
          .allocates = false, .memory = may_share, .may_fail = false, .derivative_of = "gravity_torques",
          .lanes = false, .tape = false, .counts = of_gravity)
AXODE_ROW(coriolis_derivatives, .purpose = "The matrices d(C v)/dq and d(C v)/dv are the partial "
              "derivatives of the forces of coriolis_vector.", .units = "of tau per unit of the direction",
          .takes = {q, v}, .choice = none, .entry = number, .shape = {nv, nv}, .columns = false,
          .symbols = {"d(C v)/dq", "d(C v)/dv"}, .cost = quadratic, .allocates = false, .memory = may_share,
          .may_fail = false, .derivative_of = "coriolis_vector", .lanes = false, .tape = false,
          .counts = of_terms)
AXODE_ROW(generalized_load_derivatives, .purpose = "The matrices dQ/dq and dQ/dv are the partial "
              "derivatives of the forces of generalized_loads.", .units = "of tau per unit of the direction",
          .takes = {q, v, loads}, .choice = none, .entry = number, .shape = {nv, nv}, .columns = false,
          .symbols = {"dQ/dq", "dQ/dv"}, .cost = quadratic, .allocates = false, .memory = may_share,
          .may_fail = false, .derivative_of = "generalized_loads", .lanes = false, .tape = false,
          .counts = of_loads)
AXODE_ROW(spring_force_derivatives, .purpose = "The matrices dtau/dq and dtau/dv are the partial "
              "derivatives of the forces of spring_forces.", .units = "of tau per unit of the direction",
          .takes = {q, v}, .choice = none, .entry = number, .shape = {nv, nv}, .columns = false,
          .symbols = {"dtau/dq", "dtau/dv"}, .cost = quadratic, .allocates = false, .memory = own,
          .may_fail = false, .derivative_of = "spring_forces", .lanes = false, .tape = false,
          .counts = of_springs)
AXODE_ROW(kinetic_energy_gradient, .purpose = "The vectors dT/dq and dT/dv are the gradients of the kinetic "
              "energy by configuration and velocities.", .units = "J per unit of the direction",
          .takes = {q, v}, .choice = none, .entry = number, .shape = {nv}, .columns = false,
          .symbols = {"dT/dq", "dT/dv"}, .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = false, .derivative_of = "kinetic_energy", .lanes = false, .tape = false,
          .counts = of_motion)
AXODE_ROW(motion_derivatives, .purpose = "The matrices dV/dq, dV/dv, dV'/dq and dV'/dv are the partial "
              "derivatives of the twist of a frame and of its rate, with a column for each direction.",
          .units = "of V and V' per unit of the direction", .takes = {q, v, a, place},
          .choice = representation, .entry = twist, .shape = {nv}, .columns = true,
          .symbols = {"dV/dq", "dV/dv", "dV'/dq", "dV'/dv"}, .cost = linear, .allocates = false,
          .memory = own, .may_fail = false, .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(motion_jvp, .purpose = "The changes dX, dV and dV' are the derivatives of the pose of a frame (as "
              "a body-fixed displacement), of its twist and of its rate along a direction.",
          .units = "of X, V and V' along the direction", .takes = {q, v, a, place, dq, dv, da},
          .choice = representation, .entry = twist, .shape = {}, .columns = false,
          .symbols = {"dX", "dV", "dV'"}, .cost = linear, .allocates = false, .memory = may_share,
          .may_fail = false, .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(inverse_dynamics_geometry_derivatives, .purpose = "The numbers dtau/dpi are the partial "
              "derivatives of the drive forces of inverse_dynamics by displacements pi of the joints.",
          .units = "of tau per rad, m", .takes = {q, v, a, loads}, .choice = none, .entry = number,
          .shape = {nv, n_bodies, six}, .columns = false, .symbols = {"dtau/dpi"}, .cost = quadratic,
          .allocates = false, .memory = own, .may_fail = false, .derivative_of = "inverse_dynamics",
          .lanes = false, .tape = false, .counts = of_derivatives_of_forces)
AXODE_ROW(forward_dynamics_geometry_derivatives, .purpose = "The numbers da/dpi are the partial derivatives "
              "of the accelerations of forward_dynamics by displacements pi of the joints.",
          .units = "of a per rad, m", .takes = {q, v, tau, loads}, .choice = none, .entry = number,
          .shape = {nv, n_bodies, six}, .columns = false, .symbols = {"da/dpi"}, .cost = quadratic,
          .allocates = false, .memory = own, .may_fail = true, .derivative_of = "forward_dynamics",
          .lanes = false, .tape = false, .counts = of_derivatives_of_accelerations)
AXODE_ROW(inverse_dynamics_geometry_vjp, .purpose = "The gradient of w . tau has the derivatives of a "
              "weighted sum of the drive forces of inverse_dynamics by displacements pi of the joints.",
          .units = "of w tau per rad, m", .takes = {q, v, a, weights, loads}, .choice = none, .entry = number,
          .shape = {n_bodies, six}, .columns = false, .symbols = {"by pi"}, .cost = linear,
          .allocates = false, .memory = own, .may_fail = false, .derivative_of = "inverse_dynamics",
          .lanes = false, .tape = false, .counts = of_derivatives_of_forces)
AXODE_ROW(forward_dynamics_geometry_vjp, .purpose = "The gradient of w . a has the derivatives of a "
              "weighted sum of the accelerations of forward_dynamics by displacements pi of the joints.",
          .units = "of w a per rad, m", .takes = {q, v, tau, weights, loads}, .choice = none, .entry = number,
          .shape = {n_bodies, six}, .columns = false, .symbols = {"by pi"}, .cost = linear,
          .allocates = false, .memory = own, .may_fail = true, .derivative_of = "forward_dynamics",
          .lanes = false, .tape = false, .counts = of_derivatives_of_accelerations)
AXODE_ROW(frame_geometry_jacobian, .purpose = "The matrix J maps displacements of the joints to the "
              "body-fixed twist by which they displace a frame.", .units = "rad, m per rad, m",
          .takes = {q, place}, .choice = none, .entry = number, .shape = {six, n_bodies, six},
          .columns = false, .symbols = {"J"}, .cost = linear, .allocates = false, .memory = own,
          .may_fail = false, .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(jacobian_geometry_derivatives, .purpose = "The matrices dJ/dpi are the partial derivatives of the "
              "body-fixed Jacobian of a frame by displacements pi of the joints.", .units = "of J per rad, m",
          .takes = {q, place}, .choice = none, .entry = twist, .shape = {n_bodies, six, nv}, .columns = true,
          .symbols = {"dJ/dpi"}, .cost = quadratic, .allocates = false, .memory = own, .may_fail = false,
          .derivative_of = "jacobian", .lanes = false, .tape = false, .counts = of_motion)
AXODE_ROW(inverse_dynamics_jvp, .purpose = "The vector dtau is the derivative of the drive forces of "
              "inverse_dynamics along a direction (dq, dv, da).", .units = forces,
          .takes = {q, v, a, dq, dv, da, loads}, .choice = none, .entry = number, .shape = {nv},
          .columns = false, .symbols = {"dtau"}, .together = "dtau", .cost = linear, .allocates = false,
          .memory = may_share, .may_fail = false, .derivative_of = "inverse_dynamics", .lanes = true,
          .tape = true, .counts = of_derivatives_of_forces)
AXODE_ROW(inverse_dynamics_vjp, .purpose = "The gradient of w . tau has the derivatives of a weighted sum "
              "of the drive forces of inverse_dynamics by q, v and a.",
          .units = "of w tau per unit of the direction", .takes = {q, v, a, weights, loads}, .choice = none,
          .entry = number, .shape = {nv}, .columns = false, .symbols = {"by q", "by v", "by a"},
          .together = "gradient", .cost = linear, .allocates = false, .memory = may_share, .may_fail = false,
          .derivative_of = "inverse_dynamics", .lanes = true, .tape = true,
          .counts = of_derivatives_of_forces)
AXODE_ROW(forward_dynamics_jvp, .purpose = "The vector da is the derivative of the accelerations of "
              "forward_dynamics along a direction (dq, dv, dtau).", .units = rates,
          .takes = {q, v, tau, dq, dv, dtau, loads}, .choice = none, .entry = number, .shape = {nv},
          .columns = false, .symbols = {"da"}, .together = "da", .cost = linear, .allocates = false,
          .memory = may_share, .may_fail = true, .derivative_of = "forward_dynamics", .lanes = true,
          .tape = true, .counts = of_variations_of_accelerations)
AXODE_ROW(forward_dynamics_vjp, .purpose = "The gradient of w . a has the derivatives of a weighted sum of "
              "the accelerations of forward_dynamics by q, v and tau.",
          .units = "of w a per unit of the direction", .takes = {q, v, tau, weights, loads}, .choice = none,
          .entry = number, .shape = {nv}, .columns = false, .symbols = {"by q", "by v", "by tau"},
          .together = "gradient", .cost = linear, .allocates = false, .memory = may_share, .may_fail = true,
          .derivative_of = "forward_dynamics", .lanes = true, .tape = true,
          .counts = of_variations_of_accelerations)
AXODE_ROW(inverse_dynamics_hessian, .purpose = "The Hessian has the second partial derivatives of w . tau, "
              "a weighted sum of the drive forces of inverse_dynamics.",
          .units = "of w tau per units of the directions", .takes = {q, v, a, weights, loads}, .choice = none,
          .entry = number, .shape = {nv, nv}, .columns = false,
          .symbols = {"by q, q", "by q, v", "by v, v", "by a, q"}, .together = "hessian", .cost = quadratic,
          .allocates = false, .memory = may_share, .may_fail = false, .derivative_of = "inverse_dynamics",
          .lanes = false, .tape = true, .counts = of_derivatives_of_forces)
AXODE_ROW(forward_dynamics_hessian, .purpose = "The Hessian has the second partial derivatives of w . a, a "
              "weighted sum of the accelerations of forward_dynamics.",
          .units = "of w a per units of the directions", .takes = {q, v, tau, weights, loads}, .choice = none,
          .entry = number, .shape = {nv, nv}, .columns = false,
          .symbols = {"by q, q", "by q, v", "by v, v", "by tau, q"}, .together = "hessian", .cost = cubic,
          .allocates = false, .memory = may_share, .may_fail = true, .derivative_of = "forward_dynamics",
          .lanes = false, .tape = true, .counts = of_derivatives_of_accelerations)
AXODE_ROW(inverse_dynamics_second_derivatives, .purpose = "The second partial derivatives are those of each "
              "drive force of inverse_dynamics, without loads.",
          .units = "of tau per units of the directions", .takes = {q, v, a}, .choice = none, .entry = number,
          .shape = {nv, nv, nv}, .columns = false, .symbols = {"by q, q", "by q, v", "by v, v", "by a, q"},
          .cost = cubic, .allocates = false, .memory = may_share, .may_fail = false,
          .derivative_of = "inverse_dynamics", .lanes = false, .tape = false,
          .counts = with(of_derivatives_of_forces, &Counts::joint_losses, of_the_tree()))
AXODE_ROW(forward_dynamics_second_derivatives, .purpose = "The second partial derivatives are those of each "
              "acceleration of forward_dynamics, without loads.", .units = "of a per units of the directions",
          .takes = {q, v, tau}, .choice = none, .entry = number, .shape = {nv, nv, nv}, .columns = false,
          .symbols = {"by q, q", "by q, v", "by v, v", "by tau, q"}, .cost = cubic, .allocates = false,
          .memory = own, .may_fail = true, .derivative_of = "forward_dynamics", .lanes = false, .tape = false,
          .counts = with(of_derivatives_of_accelerations, &Counts::joint_losses, of_the_tree()))
// clang-format on
#undef AXODE_ROW
