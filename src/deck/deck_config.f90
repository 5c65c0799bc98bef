! SPDX-License-Identifier: BSD-3-Clause
!> The deck as data: one type per section, with every default and unit. Later layers check only what needs the mesh or a point.
module sig_deck_config
  use sig_flow_properties, only: temperature_name
  use sig_history, only: history_t
  use sig_kinds, only: rk
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: deck_config_t, units_config_t, mesh_config_t, parameter_config_t, step_config_t, history_config_t, &
    material_config_t, plasticity_config_t, creep_config_t, value_config_t, name_config_t, &
    load_config_t, field_config_t, imposed_strain_config_t, obstacle_config_t, boundary_config_t, contact_config_t, &
    solver_config_t, point_set_config_t, reduction_config_t, output_config_t, displacement_config_t, greedy_config_t, &
    target_config_t, refine_config_t, clusters_config_t, enrichment_config_t, zone_config_t, validation_config_t, temperature_name

  !> [-] default of contact%pairing_tolerance for averaged normals, which are not exact if facets differ in size
  real(rk), parameter, public :: averaged_tolerance = 0.1_rk
  !> largest number of parameters for which sobol.f90 has direction numbers
  integer, parameter, public :: max_sobol_parameters = 10

  !> A name that has to exist in the mesh, or in the file of a field. Its line and column in the deck are for messages.
  type :: name_config_t
    character(:), allocatable :: text
    integer :: line = 0
    integer :: column = 0
  end type name_config_t

  !> A number or an expression of the parameters and, where allowed, the coordinates.
  type :: value_config_t
    !> text for muParser; a number is written so that it reads back the same
    character(:), allocatable :: text
    !> start of the names of its terms if the program wrote the text; not allocated: these names start with the text
    character(:), allocatable :: name
    !> whether the text contains neither parameters nor coordinates nor the temperature
    logical :: is_constant = .true.
    logical :: uses_parameters = .false., uses_coordinates = .false.
    !> whether it contains the time or a table of the history; they count as parameters, too
    logical :: uses_history = .false.
    !> whether it contains the temperature of the region, temperature_name
    logical :: uses_temperature = .false.
    !> value of the text, if is_constant
    real(rk) :: constant = 0
    integer :: line = 0
    integer :: column = 0
  end type value_config_t

  type :: units_config_t
    !> m, cm, mm or um: the unit of every length of the deck and of the results
    character(:), allocatable :: length
    !> N, kN or MN: the unit of every force; stresses are force / length**2
    character(:), allocatable :: force
    !> unit of the time, for people: us, ms, s, min, h, d or a; empty (default) = not given
    character(:), allocatable :: time
  end type units_config_t

  type :: mesh_config_t
    !> path as written in the deck: absolute, or relative to the deck's folder
    character(:), allocatable :: file
    !> path that can be opened from the current directory
    character(:), allocatable :: path
    !> plane_strain, plane_stress, axisymmetric or solid: a name of the table in mechanical_models
    character(:), allocatable :: model
    !> unit of the coordinates in the mesh file; default units.length
    character(:), allocatable :: length_unit
    integer :: line = 0
    integer :: column = 0
  end type mesh_config_t

  type :: parameter_config_t
    character(:), allocatable :: name
    real(rk) :: minimum = 0, maximum = 0
    !> unit of the parameter, free text for axes and reports; default empty
    character(:), allocatable :: unit
    !> whether an expression of the deck has its name
    logical :: is_used = .true.
    integer :: line = 0
  end type parameter_config_t

  !> A stretch of a history with some increments.
  type :: step_config_t
    !> [unit of time] end of the step, greater than that of the step before, or than 0
    real(rk) :: until = 0
    integer :: n_increments = 0
    !> [-] > 0: the last increment over the first; default 1, equal increments
    real(rk) :: growth = 1
  end type step_config_t

  !> Section history.
  type :: history_config_t
    !> tables, and the times of the states, which follow from the steps; none of both without the section
    type(history_t) :: states
    type(step_config_t), allocatable :: steps(:)
    !> file of each table as written in the deck; empty = its nodes stand in the deck
    type(string_t), allocatable :: files(:)
  end type history_config_t

  !> materials.<name>.plasticity: J2 plasticity. All values are expressions of the parameters, the time, tables and the temperature.
  type :: plasticity_config_t
    logical :: is_used = .false.
    !> [force/length**2] > 0; with a curve its first stress
    type(value_config_t) :: yield_stress
    !> key of the hardening: isotropic_hardening, kinematic_hardening, tangent_modulus or curve; empty (default) = perfectly plastic
    character(19) :: hardening = ''
    !> [force/length**2] value of the key: a hardening modulus >= 0, or a tangent modulus >= 0 and less than young_modulus
    type(value_config_t) :: modulus
    !> [-] curve: equivalent plastic strains, increasing from 0; shape (n_points)
    real(rk), allocatable :: curve_strains(:)
    !> [force/length**2] curve: yield stresses, not falling; shape (n_points)
    type(value_config_t), allocatable :: curve_stresses(:)
  end type plasticity_config_t

  !> materials.<name>.creep.norton: the equivalent creep strain grows by coefficient * stress**exponent per time. Values as in
  !> plasticity_config_t.
  type :: creep_config_t
    logical :: is_used = .false.
    !> [1/time / (force/length**2)**exponent] >= 0
    type(value_config_t) :: coefficient
    !> [-] >= 1
    type(value_config_t) :: exponent
  end type creep_config_t

  type :: material_config_t
    character(:), allocatable :: name
    !> physical names of the cells with this material
    type(name_config_t), allocatable :: regions(:)
    !> [force/length**2] > 0; a number or an expression of the parameters
    type(value_config_t) :: young_modulus
    !> [-] in (-1, 0.5); a number or an expression of the parameters
    type(value_config_t) :: poisson_ratio
    !> whether the material has thermal expansion; otherwise (default) temperatures cannot be imposed on it
    logical :: has_thermal_expansion = .false.
    !> [1/degree] a number or an expression of the parameters
    type(value_config_t) :: thermal_expansion
    type(plasticity_config_t) :: plasticity
    type(creep_config_t) :: creep
  contains
    procedure :: flows
  end type material_config_t

  !> Prescribed displacement of one named boundary (facets, edges or points).
  type :: boundary_config_t
    type(name_config_t) :: boundary
    !> names of the components
    character(1) :: axes(3) = ['x', 'y', 'z']
    !> whether each component is prescribed
    logical :: is_prescribed(3) = .false.
    !> [length] prescribed values
    type(value_config_t) :: displacement(3)
  end type boundary_config_t

  !> Pressure or traction on a named surface, or body force in a named region.
  type :: load_config_t
    !> boundary, or region for a body force
    type(name_config_t) :: target
    logical :: is_body_force = .false.
    logical :: has_pressure = .false.
    !> [force/length**2] pressure; a positive value pushes into the body
    type(value_config_t) :: pressure
    !> names of the components in the deck
    character(1) :: axes(3) = ['x', 'y', 'z']
    !> whether each component of the traction or the body force is given
    logical :: has_component(3) = .false.
    !> [force/length**2] traction or [force/length**3] body force
    type(value_config_t) :: components(3)
    !> coordinate that the window bounds, 0 = no window
    integer :: axis = 0
    logical :: has_minimum = .false.
    logical :: has_maximum = .false.
    !> [length] bounds of the window, expressions of the parameters
    type(value_config_t) :: minimum
    type(value_config_t) :: maximum
    !> whether facets that are partly in the window are loaded on this part (default); otherwise they are not loaded at all
    logical :: is_cut = .true.
  end type load_config_t

  !> Values at nodes, from a file.
  type :: field_config_t
    !> path as written in the deck, and one that can be opened from the current directory
    character(:), allocatable :: file
    character(:), allocatable :: path
    !> name of the field in the file
    type(name_config_t) :: name
    integer :: line = 0
    integer :: column = 0
  end type field_config_t

  !> Strains that a region would have without stress: from a temperature, or given directly.
  type :: imposed_strain_config_t
    type(name_config_t) :: region
    !> whether the strain is the material's thermal_expansion * (temperature - reference); otherwise the strain itself is given
    logical :: is_thermal = .true.
    !> temperature or isotropic strain, a sum of products of functions of parameters and place; with a field, factor of its values
    type(value_config_t) :: value
    logical :: has_field = .false.
    type(field_config_t) :: field
    !> [degree] is_thermal: temperature without strain; expression of the parameters
    type(value_config_t) :: reference
    !> whether each component of the strain tensor (not angles) is given instead of `value`, in the order of mechanical_model_t
    logical :: has_component(6) = .false.
    type(value_config_t) :: components(6)
  end type imposed_strain_config_t

  !> A rigid body that the first surface may touch.
  type :: obstacle_config_t
    !> half_space or sphere (in the plane a cylinder)
    character(:), allocatable :: type
    !> [length] a point of the half space's face or the sphere's center, expressions of the parameters
    type(value_config_t), allocatable :: place(:)
    !> [-] half space: normal out of the obstacle, not yet of unit length
    real(rk), allocatable :: normal(:)
    !> [length] sphere: expression of the parameters, > 0
    type(value_config_t) :: radius
    integer :: line = 0
    integer :: column = 0
  end type obstacle_config_t

  type :: contact_config_t
    type(name_config_t) :: first
    !> name of the second surface; empty with an obstacle
    type(name_config_t) :: second
    logical :: has_obstacle = .false.
    type(obstacle_config_t) :: obstacle
    !> whether the deck gives a direction; otherwise (default) it is the averaged outward normal of the surface with the forces
    logical :: has_direction = .false.
    !> [-] from the first body to the second or to the obstacle (a half space: against its normal), not yet of unit length
    real(rk), allocatable :: direction(:)
    integer :: direction_line = 0
    integer :: direction_column = 0
    !> auto, node_to_node or mortar
    character(12) :: formulation = 'auto'
    !> [length] mortar: parts of the surfaces that are farther apart never touch; by default 50 times the longest edge of both
    logical :: has_search_distance = .false.
    real(rk) :: search_distance = 0
    !> [-] largest lateral offset of a pair over the mesh size; default 1.0e-6 with a direction, else averaged_tolerance
    real(rk) :: pairing_tolerance = 1.0e-6_rk
    !> whether the deck gives the gap; otherwise (default) it is the distance along the direction in the mesh
    logical :: has_initial_gap = .false.
    !> [length] gap at the coordinates of each node of the first surface; negative = interference
    type(value_config_t) :: initial_gap
    !> false (default), true (bonded: the surfaces neither open nor slip) or normal (they slip, but never open)
    character(6) :: tied = 'false'
    !> whether the deck gives a coefficient of friction; otherwise (default) there is no friction
    logical :: has_friction = .false.
    !> [-] coefficient of friction, >= 0
    type(value_config_t) :: friction
  end type contact_config_t

  type :: solver_config_t
    !> auto (default), condensed, active_set or snesvi
    character(:), allocatable :: type
    !> auto (default), cholesky or gamg
    character(:), allocatable :: linear
    !> largest number of steps per parameter point: of active_set, and of each of the two attempts of snesvi; default 50
    integer :: max_iterations = 50
    !> whether a rigid motion that nothing holds is left out where no load drives it; otherwise it is an error
    logical :: holds_unloaded_motions = .true.
    !> place of the section in the deck
    integer :: line = 0
    integer :: column = 0
  end type solver_config_t

  !> A grid over the box, a list from a CSV file whose header names the parameters, Sobol's sequence, or a Latin hypercube.
  type :: point_set_config_t
    !> number of points per parameter, in the order of the deck's parameters; unallocated for other kinds of sets
    integer, allocatable :: grid(:)
    !> path of the CSV file as written in the deck, and one to open from the current directory; unallocated for other kinds of sets
    character(:), allocatable :: file
    character(:), allocatable :: path
    !> number of points of Sobol's sequence, and of a Latin hypercube; 0 = another kind of set
    integer :: n_sobol = 0
    integer :: n_latin_hypercube = 0
    !> seed of both; with 0 (default) Sobol's sequence is not changed
    integer :: seed = 0
    !> number of groups of ranks that work on different points; 0 = `auto` in the deck (default)
    integer :: n_groups = 0
    !> auto (default), factored or interpolated: how training points are solved if elastic constants vary; only for training
    character(:), allocatable :: stiffness
    integer :: line = 0
    integer :: column = 0
  end type point_set_config_t

  !> Greedy selection: training points are chosen among candidates. Each round takes those for which the indicator is largest.
  type :: greedy_config_t
    !> whether the selection is used; training is then the set of candidates
    logical :: is_used = .false.
    !> projection (default), defect or, where materials flow, audit: the indicator that compares candidates
    character(:), allocatable :: indicator
    !> number of initial points, far from each other; default 5
    integer :: n_initial = 5
    !> [-] the selection ends when no candidate has a larger indicator; default none (0). With audit
    !> reduction.inelastic_tolerance takes its place
    real(rk) :: tolerance = 0
    !> the selection ends at this number of points; default none (huge)
    integer :: max_points = huge(1)
    !> defect, audit: largest number of points per round; default 1
    integer :: batch = 1
  end type greedy_config_t

  !> A named boundary whose nodes join the reduced integration domain: all of them, or those in a window.
  type :: zone_config_t
    type(name_config_t) :: boundary
    !> names of the coordinates in the deck
    character(1) :: axes(3) = ['x', 'y', 'z']
    !> coordinate that the window bounds, 0 = no window
    integer :: axis = 0
    logical :: has_minimum = .false.
    logical :: has_maximum = .false.
    !> [length] bounds of the window
    real(rk) :: minimum = 0
    real(rk) :: maximum = 0
  end type zone_config_t

  type :: enrichment_config_t
    !> auto (default: greedy if (11) fails without hats), none, greedy (Algorithm 1) or all (both sides of every row, if possible)
    character(:), allocatable :: type
    !> [-] greedy ends when kappa is at most this, with full rank; at 1 it usually adds all hats that are possible; default 10
    real(rk) :: max_condition_number = 10
    !> first (default) or second: the side of a contact row that gets the hat, if this side can have one; otherwise the other side
    character(:), allocatable :: side
    !> largest number of hats for greedy; default none (huge)
    integer :: max_hats = huge(1)
  end type enrichment_config_t

  !> The largest error that local models may have.
  type :: target_config_t
    logical :: is_used = .false.
    !> [-] > 0
    real(rk) :: error = 0
    !> e_lambda_all (default), e_lambda_rid or e_u: a column of validation.csv
    character(:), allocatable :: measure
    !> p95 (default), median or max
    character(:), allocatable :: statistic
    !> points where the error is measured
    type(point_set_config_t) :: candidates
  end type target_config_t

  !> Refinement: snapshots are added and clusters split until the target is met.
  type :: refine_config_t
    logical :: is_used = .false.
    !> largest number of candidates that become snapshots; default 100
    integer :: max_points = 100
    !> largest number of these candidates in a round; default 5
    integer :: points_per_round = 5
  end type refine_config_t

  !> Local reduced models, each for a part of the training points.
  type :: clusters_config_t
    !> number of clusters, default 1: one model of all points; 0 = `auto` in the deck: chosen by the target or else the silhouette
    integer :: number = 1
    !> largest number of clusters for `auto` and for refine, default 8
    integer :: max_number = 8
    !> regular (default): clusters of the cells of training.grid; irregular: clusters of the training points themselves
    character(:), allocatable :: method
    !> [-] energy tail of the bases of the compared cells; default 1.0e-6
    real(rk) :: cell_pod_tolerance = 1.0e-6_rk
    !> equal (default): snapshots that differ in sign alone are alike; different: (16) as it is printed
    character(:), allocatable :: opposite_snapshots
    !> least number of snapshots of a cluster, default 2
    integer :: min_snapshots = 2
    !> refuse (default) or merge: treatment of a cluster with fewer snapshots
    character(:), allocatable :: small_clusters
    !> seed of random choices; default 1
    integer :: seed = 1
    type(target_config_t) :: target
    type(refine_config_t) :: refine
  end type clusters_config_t

  !> reduction.displacement: the nodes for which a condensed model gives displacements.
  type :: displacement_config_t
    !> auto (default): all nodes; none; boundaries
    character(:), allocatable :: type
    !> for type boundaries: boundaries whose nodes have exact displacements
    type(name_config_t), allocatable :: boundaries(:)
    !> for type boundaries: none (default) or modes (or compressed responses) at the other nodes
    character(:), allocatable :: elsewhere
  end type displacement_config_t

  !> Sections reduction and certificate.
  type :: reduction_config_t
    !> auto (default; condensed if possible and without clusters, else hhr; an error if only interpolation fails), condensed, hhr
    character(:), allocatable :: method
    !> [-] energy tail of the POD, (20); default 1.0e-8
    real(rk) :: pod_tolerance = 1.0e-8_rk
    !> number of modes instead of the tolerance; default auto (0)
    integer :: n_modes = 0
    !> [-] energy tail of the basis where the basis has more modes than those that choose the domain; default none (0)
    real(rk) :: extended_pod_tolerance = 0
    !> number of modes of the basis in addition to those that choose the domain; default 0
    integer :: extra_modes = 0
    !> whether each snapshot is divided by its Euclidean norm before the POD; default no
    logical :: is_normalized = .false.
    !> [-] energy tail of the POD of the multipliers, whose interpolation points join the domain; default none (0)
    real(rk) :: dual_pod_tolerance = 0
    !> elastic_lifting (default) or multiplier; method for prescribed displacements in the reduced model
    character(:), allocatable :: dirichlet
    !> whether zones_of_interest is auto (default) or has it in its list: nodes of loaded surfaces on which a force acts
    logical :: has_loaded_zones = .true.
    !> boundaries whose nodes (all, or those in a window) join the reduced integration domain, in addition to auto or instead of it
    type(zone_config_t), allocatable :: zones_of_interest(:)
    type(enrichment_config_t) :: enrichment
    !> [-] singular values below this share of the largest one count as zero in rank checks; default 1.0e-10
    real(rk) :: rank_tolerance = 1.0e-10_rk
    !> multipliers_and_displacements (default) or multipliers: the data that the non-negative least squares fit
    character(:), allocatable :: reconstruction
    type(displacement_config_t) :: displacement
    !> [-] >= 0: largest error of displacements by modes or compressed responses in the norm of the stiffness; default 1.0e-3
    real(rk) :: displacement_tolerance = 1.0e-3_rk
    !> whether the model gives fields; default no
    logical :: has_fields = .false.
    !> [MB] memory >= 0 for the condensed full-order operator, of displacements too if they fit; 0 = none; default: an eighth of the
    !> memory of the machine, at most 2000
    real(rk) :: max_full_order_size = 2000
    !> whether the deck leaves this size to the machine (auto)
    logical :: is_size_auto = .true.
    !> [MB] memory >= 0 of a condensed model for pivot transforms, which make its answers fast; default 256
    real(rk) :: max_transforms_size = 256
    !> whether the deck leaves it to the program
    logical :: is_transforms_size_auto = .true.
    !> [-] between 0 and 1: error of contact forces and stresses that a model of materials that flow may have; default 1.0e-2
    real(rk) :: inelastic_tolerance = 1.0e-2_rk
    !> [-] between 0 and 1: largest relative error of the contact forces from interpolation over elastic constants; default 1.0e-6
    real(rk) :: stiffness_tolerance = 1.0e-6_rk
    !> [-] certificate.max_error: > 0; 0 = none; < 0 = auto (default)
    real(rk) :: max_error = -1
  end type reduction_config_t

  type :: output_config_t
    !> results folder, absolute or relative to the deck's folder; `auto` (default) = results/<deck name> in the current directory
    character(:), allocatable :: directory
    !> path of the folder that can be opened from the current directory
    character(:), allocatable :: path
    logical :: has_displacement = .true.
    logical :: has_stress = .true.
    logical :: has_contact = .true.
    !> parameter points whose fields are written, shape (n_parameters, n_points); default: the middle of the box
    real(rk), allocatable :: points(:, :)
  end type output_config_t

  !> Section validation: largest errors of a model that is accepted, as p95 over the test points.
  type :: validation_config_t
    !> [-] accept > 0: of the contact forces
    real(rk) :: accepted_forces = 0.05_rk
    !> [-] accept_fields > 0: of displacements and stresses
    real(rk) :: accepted_fields = 0.01_rk
    !> [-] accept_strains > 0: of plastic and creep strains
    real(rk) :: accepted_strains = 0.05_rk
  end type validation_config_t

  !> A whole deck.
  type :: deck_config_t
    !> path of the deck as given on the command line, and its name without folder and ending
    character(:), allocatable :: path
    character(:), allocatable :: name
    character(:), allocatable :: title
    type(units_config_t) :: units
    type(mesh_config_t) :: mesh
    type(parameter_config_t), allocatable :: parameters(:)
    !> times and tables; none of both by default
    type(history_config_t) :: history
    !> what the numbers of a state are: the parameters and, with a history, the time and its tables; ranges of both follow from it
    type(parameter_config_t), allocatable :: state_parameters(:)
    type(material_config_t), allocatable :: materials(:)
    type(boundary_config_t), allocatable :: boundary_conditions(:)
    !> loads and imposed strains; none by default
    type(load_config_t), allocatable :: loads(:)
    type(imposed_strain_config_t), allocatable :: imposed_strains(:)
    type(contact_config_t), allocatable :: contact(:)
    type(solver_config_t) :: solver
    !> whether the deck has the section; commands that need a missing section say so
    logical :: has_training = .false.
    type(point_set_config_t) :: training
    !> greedy selection; where greedy%is_used, training has the candidates
    type(greedy_config_t) :: greedy
    logical :: has_test = .false.
    type(point_set_config_t) :: test
    type(clusters_config_t) :: clusters
    type(reduction_config_t) :: reduction
    !> limits up to which validate accepts a model
    type(validation_config_t) :: validation
    type(output_config_t) :: output
    !> PETSc options with the prefixes fom_, active_set_, vi_, pod_; may be empty
    character(:), allocatable :: petsc_options
  end type deck_config_t

contains

  !> Whether the material yields or creeps: its state then depends on those before it.
  pure logical function flows(self)
    class(material_config_t), intent(in) :: self

    flows = self%plasticity%is_used .or. self%creep%is_used
  end function flows
end module sig_deck_config
