! SPDX-License-Identifier: BSD-3-Clause
!> The deck as data: one type per section, with every default and unit. Nobody after the deck layer checks these again.
module sig_deck_config
  use sig_kinds, only: rk
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: deck_config_t, units_config_t, mesh_config_t, parameter_config_t, material_config_t, value_config_t, name_config_t
  public :: load_config_t, field_config_t, imposed_strain_config_t, obstacle_config_t
  public :: boundary_config_t, contact_config_t, solver_config_t, point_set_config_t, reduction_config_t, output_config_t
  public :: displacement_config_t, greedy_config_t
  public :: target_config_t, refine_config_t
  public :: clusters_config_t, enrichment_config_t, zone_config_t

  !> [-] default of contact%pairing_tolerance for averaged normals, which on uneven facets point a little aside
  real(rk), parameter, public :: averaged_tolerance = 0.1_rk

  !> those whose direction numbers stand in sobol.f90
  integer, parameter, public :: max_sobol_parameters = 10

  !> A name that only the mesh knows, with its place in the deck for the message.
  type :: name_config_t
    character(:), allocatable :: text
    integer :: line = 0
    integer :: column = 0
  end type name_config_t

  !> A number or an expression of the parameters and, where allowed, the coordinates.
  type :: value_config_t
    !> what muParser reads; a number is written so that it reads back the same
    character(:), allocatable :: text
    !> neither parameter nor coordinate occurs in it
    logical :: is_constant = .true.
    logical :: uses_parameters = .false.
    logical :: uses_coordinates = .false.
    !> its value where is_constant
    real(rk) :: constant = 0
    integer :: line = 0
    integer :: column = 0
  end type value_config_t

  type :: units_config_t
    !> m, cm, mm or um; every length of the deck and of the results
    character(:), allocatable :: length
    !> N, kN or MN; stresses are force / length**2
    character(:), allocatable :: force
  end type units_config_t

  type :: mesh_config_t
    !> path relative to the deck's folder, as written
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
    real(rk) :: minimum = 0
    real(rk) :: maximum = 0
    !> free text for axes and reports; default empty
    character(:), allocatable :: unit
    integer :: line = 0
  end type parameter_config_t

  type :: material_config_t
    character(:), allocatable :: name
    !> physical names of cells
    type(name_config_t), allocatable :: regions(:)
    !> [force/length**2] > 0; a number or an expression of the parameters
    type(value_config_t) :: young_modulus
    !> [-] in (-1, 0.5); likewise
    type(value_config_t) :: poisson_ratio
    !> otherwise (default) temperatures cannot be imposed on it
    logical :: has_thermal_expansion = .false.
    !> [1/degree] a number or an expression of the parameters
    type(value_config_t) :: thermal_expansion
  end type material_config_t

  !> Prescribed displacement of one named boundary (facets or points).
  type :: boundary_config_t
    type(name_config_t) :: boundary
    !> names of the components
    character(1) :: axes(3) = ['x', 'y', 'z']
    !> which components are prescribed
    logical :: is_prescribed(3) = .false.
    !> [length] their values
    type(value_config_t) :: displacement(3)
  end type boundary_config_t

  !> Pressure or traction on a named surface, or body force in a named region.
  type :: load_config_t
    !> boundary, or region of a body force
    type(name_config_t) :: target
    logical :: is_body_force = .false.
    logical :: has_pressure = .false.
    !> [force/length**2] > 0 pushes into the body
    type(value_config_t) :: pressure
    !> names of the components in the deck
    character(1) :: axes(3) = ['x', 'y', 'z']
    !> components of the traction or the body force that are given
    logical :: has_component(3) = .false.
    !> [force/length**2 or force/length**3]
    type(value_config_t) :: components(3)
    !> window: bounded coordinate, 0 = none
    integer :: axis = 0
    logical :: has_minimum = .false.
    logical :: has_maximum = .false.
    !> [length] expressions of the parameters
    type(value_config_t) :: minimum
    type(value_config_t) :: maximum
    !> cut the facets at the window (default), or take those that lie in it
    logical :: is_cut = .true.
  end type load_config_t

  !> Values at nodes, from a file.
  type :: field_config_t
    !> as written, and openable from the current directory
    character(:), allocatable :: file
    character(:), allocatable :: path
    !> of the field in the file
    type(name_config_t) :: name
    integer :: line = 0
    integer :: column = 0
  end type field_config_t

  !> Strains that a region would have without stress: by a temperature, or as they are.
  type :: imposed_strain_config_t
    type(name_config_t) :: region
    !> the material's thermal_expansion * (temperature - reference); otherwise the strain itself is given
    logical :: is_thermal = .true.
    !> temperature or isotropic strain, a sum of products of the parameters and the place; the factor of a field's values
    type(value_config_t) :: value
    logical :: has_field = .false.
    type(field_config_t) :: field
    !> [degree] is_thermal: where there is no strain; expression of the parameters
    type(value_config_t) :: reference
    !> components of the strain tensor that are given in place of value, in the order of mechanical_model_t
    logical :: has_component(6) = .false.
    type(value_config_t) :: components(6)
  end type imposed_strain_config_t

  !> A rigid body that the first surface may touch.
  type :: obstacle_config_t
    !> half_space or sphere (a cylinder in the plane)
    character(:), allocatable :: type
    !> [length] a point of the half space's face or the sphere's center, expressions of the parameters
    type(value_config_t), allocatable :: place(:)
    !> [-] half space: out of the obstacle, not yet of unit length
    real(rk), allocatable :: normal(:)
    !> [length] sphere: expression of the parameters, > 0
    type(value_config_t) :: radius
    integer :: line = 0
    integer :: column = 0
  end type obstacle_config_t

  type :: contact_config_t
    type(name_config_t) :: first
    !> empty with an obstacle
    type(name_config_t) :: second
    logical :: has_obstacle = .false.
    type(obstacle_config_t) :: obstacle
    !> otherwise (default) the averaged outward normals of the first surface count
    logical :: has_direction = .false.
    !> [-] from the first body to the second or to the obstacle (a half space: against its normal), not yet of unit length
    real(rk), allocatable :: direction(:)
    integer :: direction_line = 0
    integer :: direction_column = 0
    !> auto, node_to_node or mortar
    character(12) :: formulation = 'auto'
    !> [length] mortar: surfaces that are farther apart never touch; otherwise (default) 50 times the longest edge of both
    logical :: has_search_distance = .false.
    real(rk) :: search_distance = 0
    !> [-] largest lateral offset of a pair over the mesh size; default 1.0e-6 along a direction, else averaged_tolerance
    real(rk) :: pairing_tolerance = 1.0e-6_rk
    !> otherwise (default) the distance of the two nodes along the direction is the gap
    logical :: has_initial_gap = .false.
    !> [length] at the first node's coordinates; negative = interference
    type(value_config_t) :: initial_gap
  end type contact_config_t

  type :: solver_config_t
    !> auto (default), condensed, active_set or snesvi
    character(:), allocatable :: type
    !> auto (default), cholesky or gamg
    character(:), allocatable :: linear
    !> active-set or Newton steps per parameter point; default 50
    integer :: max_iterations = 50
    !> of the section
    integer :: line = 0
    integer :: column = 0
  end type solver_config_t

  !> A grid over the box, a list from a CSV file whose header names the parameters, or a sequence that fills the box.
  type :: point_set_config_t
    !> points per parameter, in the order of the deck's parameters; unallocated where it is none
    integer, allocatable :: grid(:)
    !> as written, and openable from the current directory; unallocated where it is none
    character(:), allocatable :: file
    character(:), allocatable :: path
    !> points of Sobol's sequence, or of a Latin hypercube; 0 = another kind of set
    integer :: n_sobol = 0
    integer :: n_latin_hypercube = 0
    !> of either; with 0 (default) Sobol's sequence as it is
    integer :: seed = 0
    !> groups of ranks that work on different points; 0 = `auto` in the deck (default)
    integer :: n_groups = 0
    !> of training only: auto (default), factored or interpolated; where the fields come from as elastic constants vary
    character(:), allocatable :: stiffness
    integer :: line = 0
    integer :: column = 0
  end type point_set_config_t

  !> Training points that are chosen among candidates, one round after the other, where they are worst represented.
  type :: greedy_config_t
    !> training is the set of candidates
    logical :: is_used = .false.
    !> projection (default) or defect: what is compared
    character(:), allocatable :: indicator
    !> points to begin with, far from each other; default 5
    integer :: n_initial = 5
    !> [-] ends when no candidate has a larger indicator; default none (0)
    real(rk) :: tolerance = 0
    !> ends at so many points; default none (huge)
    integer :: max_points = huge(1)
    !> defect: points of a round; default 1
    integer :: batch = 1
  end type greedy_config_t

  !> A named boundary whose nodes join the reduced integration domain: all of them, or those in a window.
  type :: zone_config_t
    type(name_config_t) :: boundary
    !> names of the coordinates in the deck
    character(1) :: axes(3) = ['x', 'y', 'z']
    !> bounded coordinate, 0 = none
    integer :: axis = 0
    logical :: has_minimum = .false.
    logical :: has_maximum = .false.
    !> [length]
    real(rk) :: minimum = 0
    real(rk) :: maximum = 0
  end type zone_config_t

  type :: enrichment_config_t
    !> auto (default: greedy where (11) fails without hats), none, greedy (Algorithm 1) or all (both hats of every pair)
    character(:), allocatable :: type
    !> [-] greedy ends at this kappa with full rank; at 1 every pair gets a hat; default 10
    real(rk) :: max_condition_number = 10
    !> first (default) or second: the node of a pair that carries its hat, unless its displacement is prescribed
    character(:), allocatable :: side
    !> greedy takes no more; default none (huge)
    integer :: max_hats = huge(1)
  end type enrichment_config_t

  !> The error that local models are to have.
  type :: target_config_t
    logical :: is_used = .false.
    !> [-] > 0
    real(rk) :: error = 0
    !> e_lambda_all (default), e_lambda_rid or e_u: a column of validation.csv
    character(:), allocatable :: measure
    !> p95 (default), median or max
    character(:), allocatable :: statistic
    !> points where it is measured
    type(point_set_config_t) :: candidates
  end type target_config_t

  !> Snapshots added and clusters split until the target is met.
  type :: refine_config_t
    logical :: is_used = .false.
    !> candidates that may become snapshots; default 100
    integer :: max_points = 100
    !> how many of them in a round, for one cluster; default 5
    integer :: points_per_round = 5
  end type refine_config_t

  !> Local reduced models, each of a part of the training points.
  type :: clusters_config_t
    !> default 1: one model of all points; 0 = `auto` in the deck: as the silhouette says, up to max_number
    integer :: number = 1
    !> default 8
    integer :: max_number = 8
    !> regular (default): of the cells of training.grid; irregular: of the training points themselves
    character(:), allocatable :: method
    !> [-] energy tail of the bases of the cells that are compared; default 1.0e-6
    real(rk) :: cell_pod_tolerance = 1.0e-6_rk
    !> equal (default): snapshots that differ in sign alone are alike; different: (16) as it is printed
    character(:), allocatable :: opposite_snapshots
    !> snapshots that a cluster must have, default 2
    integer :: min_snapshots = 2
    !> refuse (default) or merge: what becomes of a cluster with fewer
    character(:), allocatable :: small_clusters
    !> faster_pam (default) or alternating: how the medoids are found
    character(:), allocatable :: algorithm
    !> of what is drawn at random; default 1
    integer :: seed = 1
    type(target_config_t) :: target
    type(refine_config_t) :: refine
  end type clusters_config_t

  !> reduction.displacement: of which nodes a condensed model answers displacements.
  type :: displacement_config_t
    !> auto (default): all nodes, exactly where there is room, else by POD modes; none; boundaries
    character(:), allocatable :: type
    !> of type boundaries: the nodes with exact displacements
    type(name_config_t), allocatable :: boundaries(:)
    !> of type boundaries: none (default) or modes
    character(:), allocatable :: elsewhere
  end type displacement_config_t

  type :: reduction_config_t
    !> auto (default): condensed where the problem fits into max_full_order_size, else hhr; condensed; hhr
    character(:), allocatable :: method
    !> [-] energy tail of the POD, (20); default 1.0e-8
    real(rk) :: pod_tolerance = 1.0e-8_rk
    !> modes in place of the tolerance; default auto (0)
    integer :: n_modes = 0
    !> [-] energy tail of the basis where that has more modes than choose the domain; default none (0)
    real(rk) :: extended_pod_tolerance = 0
    !> modes of the basis beyond those that choose the domain; default 0
    integer :: extra_modes = 0
    !> each snapshot is divided by its size before the POD; default no
    logical :: is_normalized = .false.
    !> [-] energy tail of the POD of the multipliers, whose interpolation points join the domain; default none (0)
    real(rk) :: dual_pod_tolerance = 0
    !> elastic_lifting (default) or multiplier; method: prescribed values in the reduced model
    character(:), allocatable :: dirichlet
    !> zones_of_interest: auto (default), every loaded surface where a point of the parameters can load it
    logical :: has_loaded_zones = .true.
    !> boundaries whose nodes all join the reduced integration domain, beside auto or in its place
    type(zone_config_t), allocatable :: zones_of_interest(:)
    !> join (default): the cells of a contact node's partner are added; remove: a contact node without partner has no equation
    character(:), allocatable :: unpaired_nodes
    type(enrichment_config_t) :: enrichment
    !> [-] singular values below this times the largest count as zero in rank checks; default 1.0e-10
    real(rk) :: rank_tolerance = 1.0e-10_rk
    !> multipliers_and_displacements (default) or multipliers: what the non-negative least squares fit
    character(:), allocatable :: reconstruction
    type(displacement_config_t) :: displacement
    !> the model answers fields; default no
    logical :: has_fields = .false.
    !> [MB] >= 0 for the condensed full-order operator: of the multipliers, and of the displacement if it fits; 0 = none; default 64
    real(rk) :: max_full_order_size = 64
    !> [MB] >= 0 that a condensed model may spend on pivot transforms, which make its answers fast; default 256
    real(rk) :: max_transforms_size = 256
    !> [-] between 0 and 1: relative error of the contact forces that interpolation over elastic constants may make; default 1.0e-6
    real(rk) :: stiffness_tolerance = 1.0e-6_rk
    !> [-] certificate.max_error: > 0; 0 = none; < 0 = auto (default)
    real(rk) :: max_error = -1
  end type reduction_config_t

  type :: output_config_t
    !> results folder, relative to the deck; `auto` (default) = results/<deck name> below the current directory
    character(:), allocatable :: directory
    !> openable from the current directory
    character(:), allocatable :: path
    logical :: has_displacement = .true.
    logical :: has_stress = .true.
    logical :: has_contact = .true.
    !> parameter points whose fields are written, shape (n_parameters, n_points); default: the middle of the box
    real(rk), allocatable :: points(:, :)
  end type output_config_t

  !> A whole deck.
  type :: deck_config_t
    !> path of the deck as given on the command line, and its name without folder and ending
    character(:), allocatable :: path
    character(:), allocatable :: name
    character(:), allocatable :: title
    type(units_config_t) :: units
    type(mesh_config_t) :: mesh
    type(parameter_config_t), allocatable :: parameters(:)
    type(material_config_t), allocatable :: materials(:)
    type(boundary_config_t), allocatable :: boundary_conditions(:)
    !> none by default, as imposed strains
    type(load_config_t), allocatable :: loads(:)
    type(imposed_strain_config_t), allocatable :: imposed_strains(:)
    type(contact_config_t), allocatable :: contact(:)
    type(solver_config_t) :: solver
    !> the deck has the section; commands that need a section which is not there say so
    logical :: has_training = .false.
    type(point_set_config_t) :: training
    !> greedy%is_used: training has the candidates
    type(greedy_config_t) :: greedy
    logical :: has_test = .false.
    type(point_set_config_t) :: test
    type(clusters_config_t) :: clusters
    type(reduction_config_t) :: reduction
    !> [-] validation.accept > 0: largest p95 of e_lambda_all of a model that is good enough; default 0.05
    real(rk) :: accepted_error = 0.05_rk
    type(output_config_t) :: output
    !> PETSc options with the prefixes fom_, active_set_, vi_, pod_; may be empty
    character(:), allocatable :: petsc_options
  end type deck_config_t
end module sig_deck_config
