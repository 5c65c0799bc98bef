! SPDX-License-Identifier: BSD-3-Clause
!> A trained model as data: all that a query needs, and what describes it. Nothing here depends on a mesh file or a deck.
module sig_model
  use sig_bits, only: n_words
  use sig_kinds, only: rk
  use sig_model_choice, only: model_choice_t
  use sig_term_set, only: start_terms, term_set_t
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: model_t, contact_side_t, reduced_model_t, enrichment_history_t, full_order_t, validation_statistics_t
  public :: complete_model, complete_cluster

  !> layout of the file; a change that an older reader would misread raises it (4 is the first of a release)
  integer, parameter, public :: model_format_version = 4
  !> oldest layout that is still read
  integer, parameter, public :: oldest_model_format = 4
  !> the two values of model_t%reconstruction
  character(*), parameter, public :: reconstruct_with_displacements = 'multipliers_and_displacements'
  character(*), parameter, public :: reconstruct_from_multipliers = 'multipliers'

  !> What Algorithm 1 found: first the modes without hat functions, then an entry per hat, in the order in which they joined.
  !>
  !> The leading n_columns columns of the basis make the reduced model of an entry.
  type :: enrichment_history_t
    !> multiplier whose pair carries the hat, 1-based among all multipliers; 0 for the first entry
    integer, allocatable :: rows(:)
    !> node of the hat, natural, 1-based; 0 for the first entry
    integer, allocatable :: nodes(:)
    !> POD modes and hats; with prescribed rows the basis has fewer columns
    integer, allocatable :: n_columns(:)
    !> of (11)
    integer, allocatable :: ranks(:)
    !> [-] kappa of (11), infinite below full rank
    real(rk), allocatable :: condition_numbers(:)
    !> [-] largest singular value of the contact rows over the smallest of the min(rows, columns) ones: what the algorithm lowers
    real(rk), allocatable :: singular_ratios(:)
    !> [-] of K_r
    real(rk), allocatable :: stiffness_conditions(:)
  end type enrichment_history_t

  !> Reduced model of one cluster.
  !>
  !> u = lifting theta' + basis gamma with the leading terms theta', those that prescribe displacements;
  !> K_r gamma + M' lambda = load theta, M gamma <= gap theta, lambda >= 0 and complementary.
  !> Source: (10). theta(n_terms) are the values of the model's terms. Numbers of nodes, cells and dofs are natural, 1-based.
  type :: reduced_model_t
    !> columns of the basis: what prescribed rows leave of the POD modes, then the hats
    integer :: n_modes = 0
    !> POD modes that choose the domain (l of the paper), further ones in the basis, hat functions
    integer :: n_pod_modes = 0
    integer :: n_extra_modes = 0
    integer :: n_hats = 0
    !> multipliers of the reduced integration domain
    integer :: n_rows = 0
    !> [-] V, shape (n_dofs, n_modes)
    real(rk), allocatable :: basis(:, :)
    !> [length per unit of theta] of the leading terms; the others prescribe nothing; shape (n_dofs, n_lifted_terms)
    real(rk), allocatable :: lifting(:, :)
    !> [force / length] K_r, neither symmetric nor definite, shape (n_modes, n_modes)
    real(rk), allocatable :: reduced_stiffness(:, :)
    !> [-] M, shape (n_rows, n_modes)
    real(rk), allocatable :: contact_matrix(:, :)
    !> [force per unit of theta] shape (n_modes, n_terms)
    real(rk), allocatable :: load(:, :)
    !> [length per unit of theta] shape (n_rows, n_terms)
    real(rk), allocatable :: gap(:, :)
    !> A_lambda: index of each row among all multipliers, ascending, shape (n_rows)
    integer, allocatable :: contact_rows(:)
    !> L, L', and the cells of the reduced integration domain
    integer, allocatable :: seed_nodes(:)
    integer, allocatable :: facing_nodes(:)
    integer, allocatable :: cells(:)
    !> A, I, A_c
    integer, allocatable :: interior_dofs(:)
    integer, allocatable :: interface_dofs(:)
    integer, allocatable :: contact_dofs(:)
    !> its snapshots among the training points, 1-based, ascending
    integer, allocatable :: training_points(:)
    !> [force] multipliers of the snapshots, shape (n_multipliers, n_snapshots)
    real(rk), allocatable :: dual_snapshots(:, :)
    !> [length] normal displacements of the snapshots, first sides, then second sides, shape (n_contact_values, n_snapshots);
    !> no rows: the reconstruction uses multipliers only
    real(rk), allocatable :: contact_displacement_snapshots(:, :)
    !> [-] the same displacements of basis and lifting, (n_contact_values, n_modes or n_lifted_terms)
    real(rk), allocatable :: contact_value_basis(:, :)
    real(rk), allocatable :: contact_value_lifting(:, :)
    !> active sets of the reduced answers at the training points, as bits: where a query starts, shape (n_words(n_rows), n_points);
    !> no columns: a query starts with what penetrates
    integer, allocatable :: start_sets(:, :)
    !> [length] of the snapshots, descending
    real(rk), allocatable :: singular_values(:)
    !> [-] kappa of M, (11); infinite when rank < n_rows
    real(rk) :: condition_number = 1
    integer :: rank = 0
    !> [-] of K_r
    real(rk) :: stiffness_condition = 1
    !> of K_r: modes that the equations determine
    integer :: stiffness_rank = 0
    !> of the basis on the domain: n_modes, unless columns depend on each other there
    integer :: basis_rank = 0
    !> loaded, prescribed and contact dofs in the domain, and hats: as many modes as these the equations can determine
    integer :: primal_rank_expected = 0
    type(enrichment_history_t) :: history
    !> sentences of the training
    type(string_t), allocatable :: warnings(:)
  end type reduced_model_t

  !> The full-order model condensed to its multipliers, as far as there was room: what answers where the reduced model has none.
  !>
  !> 0 <= lambda, W lambda + free_opening theta >= 0, complementary; u = G theta' - H lambda with the leading terms theta'.
  type :: full_order_t
    !> [length/force] W, shape (n_multipliers, n_multipliers); without it the rest is empty too
    real(rk), allocatable :: compliance(:, :)
    !> [length per unit of theta] D - B G, shape (n_multipliers, n_terms)
    real(rk), allocatable :: free_opening(:, :)
    !> [length per unit of theta] G of the leading terms, the others drive nothing; shape (n_dofs, n_driving_terms), or no columns
    real(rk), allocatable :: free_response(:, :)
    !> [length/force] H, shape (n_dofs, n_multipliers), or no columns
    real(rk), allocatable :: contact_response(:, :)
  contains
    procedure :: has_multipliers
    procedure :: has_displacement
  end type full_order_t

  !> Nodes of one side of all contacts; those of contact k are starts(k) + 1 ... starts(k + 1).
  type :: contact_side_t
    !> shape (n_multipliers + 1)
    integer, allocatable :: starts(:)
    !> tags of the mesh file; on the first side the node that carries the contact's force comes first
    integer, allocatable :: tags(:)
    !> [-] share of the contact's force on each node, shape (size(tags))
    real(rk), allocatable :: weights(:)
    !> [length] shape (n_dim, size(tags))
    real(rk), allocatable :: coordinates(:, :)
  contains
    procedure :: owner_tag
  end type contact_side_t

  !> Errors against the full-order model over a test set; no entries until validated.
  type :: validation_statistics_t
    !> e_u, e_lambda_rid, ...; all arrays have their length
    type(string_t), allocatable :: names(:)
    real(rk), allocatable :: minimum(:)
    real(rk), allocatable :: median(:)
    real(rk), allocatable :: p95(:)
    real(rk), allocatable :: maximum(:)
    !> how many of the points each method answered, none included; no entries until validated
    type(string_t), allocatable :: method_names(:)
    integer, allocatable :: method_counts(:)
  end type validation_statistics_t

  !> A whole model.
  type :: model_t
    integer :: format_version = model_format_version
    character(:), allocatable :: code_version
    !> effective deck, for people
    character(:), allocatable :: deck_text
    character(:), allocatable :: title
    !> hash of physics and mesh, as in the snapshots
    character(:), allocatable :: provenance
    character(:), allocatable :: mesh_hash
    character(:), allocatable :: length_unit
    character(:), allocatable :: force_unit
    type(string_t), allocatable :: parameter_names(:)
    type(string_t), allocatable :: parameter_units(:)
    !> minimum and maximum, shape (2, n_parameters)
    real(rk), allocatable :: box(:, :)
    !> shape (n_parameters, n_points)
    real(rk), allocatable :: training_points(:, :)
    !> theta as a function of the parameters
    type(term_set_t) :: terms
    integer :: n_nodes = 0
    integer :: n_dofs = 0
    integer :: n_dim = 0
    integer :: n_multipliers = 0
    !> tags of the mesh file, shape (n_nodes), or none
    integer, allocatable :: node_tags(:)
    !> [length] shape (n_dim, n_nodes), or none
    real(rk), allocatable :: coordinates(:, :)
    !> at least one node per contact
    type(contact_side_t) :: first_side
    !> no node where a contact is that with a rigid obstacle
    type(contact_side_t) :: second_side
    !> [length, or its square but in plane models] pressure = multiplier / area, shape (n_multipliers)
    real(rk), allocatable :: areas(:)
    !> [length per unit of theta] initial gaps of all contacts, shape (n_multipliers, n_terms)
    real(rk), allocatable :: gap(:, :)
    !> [-]
    real(rk) :: pod_tolerance = 0
    !> elastic_lifting or multiplier
    character(:), allocatable :: dirichlet
    !> reconstruct_with_displacements or reconstruct_from_multipliers
    character(:), allocatable :: reconstruction
    type(reduced_model_t), allocatable :: clusters(:)
    !> which cluster answers where; empty with one cluster
    type(model_choice_t) :: choice
    type(full_order_t) :: full_order
    type(validation_statistics_t) :: validation
  end type model_t

  interface fill_missing
    procedure fill_text, fill_texts, fill_integers, fill_integer_matrix, fill_reals, fill_matrix
  end interface fill_missing

contains

  !> Gives every part that is not allocated its empty value, so that nobody has to ask.
  pure subroutine complete_model(model)
    type(model_t), intent(inout) :: model
    integer :: i_cluster

    call fill_missing(model%code_version)
    call fill_missing(model%deck_text)
    call fill_missing(model%title)
    call fill_missing(model%provenance)
    call fill_missing(model%mesh_hash)
    call fill_missing(model%length_unit)
    call fill_missing(model%force_unit)
    call fill_missing(model%dirichlet)
    call fill_missing(model%reconstruction)
    call fill_missing(model%parameter_names)
    call fill_missing(model%parameter_units)
    call fill_missing(model%box, 2)
    call fill_missing(model%training_points, size(model%parameter_names))
    if (model%terms%n_terms() == 0) call start_terms(model%parameter_names, [string_t ::], .false., model%terms)
    call fill_missing(model%node_tags)
    call fill_missing(model%coordinates, model%n_dim)
    call complete_side(model%first_side, model%n_dim, model%n_multipliers)
    call complete_side(model%second_side, model%n_dim, model%n_multipliers)
    call fill_missing(model%areas)
    call fill_missing(model%gap, model%n_multipliers)
    call fill_missing(model%validation%names)
    call fill_missing(model%validation%minimum)
    call fill_missing(model%validation%median)
    call fill_missing(model%validation%p95)
    call fill_missing(model%validation%maximum)
    call fill_missing(model%validation%method_names)
    call fill_missing(model%validation%method_counts)
    call fill_missing(model%full_order%compliance, 0)
    call fill_missing(model%full_order%free_opening, size(model%full_order%compliance, 1))
    call fill_missing(model%full_order%free_response, model%n_dofs)
    call fill_missing(model%full_order%contact_response, model%n_dofs)
    if (.not. allocated(model%clusters)) allocate (model%clusters(0))
    do i_cluster = 1, size(model%clusters)
      call complete_cluster(model%clusters(i_cluster), model%n_dofs, model%n_multipliers)
    end do
  end subroutine complete_model

  pure subroutine complete_side(side, n_dim, n_multipliers)
    type(contact_side_t), intent(inout) :: side
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_multipliers

    if (.not. allocated(side%starts)) allocate (side%starts(n_multipliers + 1), source=0)
    call fill_missing(side%tags)
    call fill_missing(side%weights)
    call fill_missing(side%coordinates, n_dim)
  end subroutine complete_side

  !> The same for one cluster.
  pure subroutine complete_cluster(cluster, n_dofs, n_multipliers)
    type(reduced_model_t), intent(inout) :: cluster
    integer, intent(in) :: n_dofs
    integer, intent(in) :: n_multipliers

    call fill_missing(cluster%basis, n_dofs)
    call fill_missing(cluster%lifting, n_dofs)
    call fill_missing(cluster%reduced_stiffness, cluster%n_modes)
    call fill_missing(cluster%contact_matrix, cluster%n_rows)
    call fill_missing(cluster%load, cluster%n_modes)
    call fill_missing(cluster%gap, cluster%n_rows)
    call fill_missing(cluster%contact_rows)
    call fill_missing(cluster%seed_nodes)
    call fill_missing(cluster%facing_nodes)
    call fill_missing(cluster%cells)
    call fill_missing(cluster%interior_dofs)
    call fill_missing(cluster%interface_dofs)
    call fill_missing(cluster%contact_dofs)
    call fill_missing(cluster%training_points)
    call fill_missing(cluster%dual_snapshots, n_multipliers)
    call fill_missing(cluster%contact_displacement_snapshots, 0)
    call fill_missing(cluster%contact_value_basis, 0)
    call fill_missing(cluster%contact_value_lifting, 0)
    call fill_missing(cluster%start_sets, n_words(cluster%n_rows))
    call fill_missing(cluster%singular_values)
    call fill_missing(cluster%history%rows)
    call fill_missing(cluster%history%nodes)
    call fill_missing(cluster%history%n_columns)
    call fill_missing(cluster%history%ranks)
    call fill_missing(cluster%history%condition_numbers)
    call fill_missing(cluster%history%singular_ratios)
    call fill_missing(cluster%history%stiffness_conditions)
    call fill_missing(cluster%warnings)
  end subroutine complete_cluster

  !> Of the first side: tag of the node that carries the force of contact k.
  pure integer function owner_tag(self, k)
    class(contact_side_t), intent(in) :: self
    integer, intent(in) :: k

    owner_tag = self%tags(self%starts(k) + 1)
  end function owner_tag

  !> The multipliers of all contacts can be answered.
  pure logical function has_multipliers(self)
    class(full_order_t), intent(in) :: self

    has_multipliers = .false.
    if (allocated(self%compliance)) has_multipliers = size(self%compliance) > 0
  end function has_multipliers

  !> The displacement can.
  pure logical function has_displacement(self)
    class(full_order_t), intent(in) :: self

    has_displacement = .false.
    if (allocated(self%contact_response)) has_displacement = size(self%contact_response) > 0
  end function has_displacement

  pure subroutine fill_text(text)
    character(:), allocatable, intent(inout) :: text

    if (.not. allocated(text)) text = ''
  end subroutine fill_text

  pure subroutine fill_texts(texts)
    type(string_t), allocatable, intent(inout) :: texts(:)

    if (.not. allocated(texts)) allocate (texts(0))
  end subroutine fill_texts

  pure subroutine fill_integers(values)
    integer, allocatable, intent(inout) :: values(:)

    if (.not. allocated(values)) allocate (values(0))
  end subroutine fill_integers

  pure subroutine fill_integer_matrix(values, n_rows)
    integer, allocatable, intent(inout) :: values(:, :)
    integer, intent(in) :: n_rows

    if (.not. allocated(values)) allocate (values(n_rows, 0))
  end subroutine fill_integer_matrix

  pure subroutine fill_reals(values)
    real(rk), allocatable, intent(inout) :: values(:)

    if (.not. allocated(values)) allocate (values(0))
  end subroutine fill_reals

  pure subroutine fill_matrix(values, n_rows)
    real(rk), allocatable, intent(inout) :: values(:, :)
    integer, intent(in) :: n_rows

    if (.not. allocated(values)) allocate (values(n_rows, 0))
  end subroutine fill_matrix
end module sig_model
