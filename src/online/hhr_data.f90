! SPDX-License-Identifier: BSD-3-Clause
!> A hyper-reduced model of one cluster of snapshots, (10), as data: what training makes and a file keeps.
module sig_hhr_data
  use sig_bits, only: n_words
  use sig_hhr_stiffness, only: hhr_stiffness_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_lifted_data, only: lifted_data_t
  use sig_missing_parts, only: fill_missing
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: hhr_data_t, enrichment_history_t, add_lifted, complete_cluster, fill_openings, stiffness_at

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

  !> Hyper-reduced model of one cluster.
  !>
  !> u = lifting theta' + basis gamma with the lifted terms theta', those that prescribe displacements or impose strains;
  !> K_r gamma + M' lambda = load theta, M gamma <= gap theta, lambda >= 0 and complementary. Where the stiffness depends on the
  !> parameters, K_r and the load have further parts (varying).
  !> Source: (10). theta(n_terms) are the values of the model's terms. Numbers of nodes, cells and dofs are natural, 1-based.
  type :: hhr_data_t
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
    !> [length per unit of theta] of the lifted terms, shape (n_dofs, n_lifted_terms)
    real(rk), allocatable :: lifting(:, :)
    !> their numbers, 1-based; a term may stand there twice; shape (n_lifted_terms)
    integer, allocatable :: lifted_terms(:)
    !> what depends on the elastic constants, where these depend on the parameters
    type(hhr_stiffness_t) :: varying
    !> [force / length] K_r, neither symmetric nor definite, without the parts that vary; shape (n_modes, n_modes)
    real(rk), allocatable :: reduced_stiffness(:, :)
    !> [-] M, shape (n_rows, n_modes)
    real(rk), allocatable :: contact_matrix(:, :)
    !> [force per unit of theta] without the parts that vary, shape (n_modes, n_terms)
    real(rk), allocatable :: load(:, :)
    !> [length per unit of theta] shape (n_rows, n_terms)
    real(rk), allocatable :: gap(:, :)
    !> rows that hold bodies which only contact holds where K_r does not (sig_hhr_system), 1-based among the n_rows
    integer, allocatable :: anchors(:)
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
    !> [length] normal displacements of the snapshots, first sides, then second sides, shape (n_contact_values, n_snapshots)
    real(rk), allocatable :: contact_displacement_snapshots(:, :)
    !> the reconstruction fits these displacements, too
    logical :: fits_displacements = .true.
    !> [-] the same displacements of basis and lifting, (n_contact_values, n_modes or n_lifted_terms)
    real(rk), allocatable :: contact_value_basis(:, :)
    real(rk), allocatable :: contact_value_lifting(:, :)
    !> [length per unit of theta] initial gaps of all contacts, shape (n_multipliers, n_terms), or no columns
    real(rk), allocatable :: contact_gap(:, :)
    !> [-] work of each contact force on each rigid motion that only contact holds, shape (n_multipliers, n_motions)
    real(rk), allocatable :: motion_closing(:, :)
    !> [force per unit of theta] and of the loads, shape (n_terms, n_motions)
    real(rk), allocatable :: motion_load(:, :)
    !> bounds answers where the matrix of all contacts has no room
    type(lifted_data_t) :: certificate
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
  end type hhr_data_t

contains

  !> Gives every part that is not allocated its empty value, so that nobody has to ask.
  pure subroutine complete_cluster(cluster, n_dofs, n_multipliers)
    type(hhr_data_t), intent(inout) :: cluster
    integer, intent(in) :: n_dofs
    integer, intent(in) :: n_multipliers
    integer :: i

    call fill_missing(cluster%basis, n_dofs)
    call fill_missing(cluster%lifting, n_dofs)
    if (.not. allocated(cluster%lifted_terms)) cluster%lifted_terms = [(i, i=1, size(cluster%lifting, 2))]
    call cluster%varying%complete()
    call fill_missing(cluster%reduced_stiffness, cluster%n_modes)
    call fill_missing(cluster%contact_matrix, cluster%n_rows)
    call fill_missing(cluster%load, cluster%n_modes)
    call fill_missing(cluster%gap, cluster%n_rows)
    call fill_missing(cluster%anchors)
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
    call fill_missing(cluster%contact_gap, n_multipliers)
    call fill_missing(cluster%motion_closing, n_multipliers)
    if (.not. allocated(cluster%motion_load)) allocate (cluster%motion_load(size(cluster%load, 2), 0))
    call cluster%certificate%complete()
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

  !> y = y + factor * a theta' with the lifted terms, for queries: nothing is allocated.
  subroutine add_lifted(cluster, factor, a, theta, y)
    type(hhr_data_t), intent(in) :: cluster
    real(rk), intent(in) :: factor
    !> shape (size(y), n_lifted_terms)
    real(rk), contiguous, intent(in) :: a(:, :)
    !> values of all terms
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(inout) :: y(:)
    integer :: i
    logical :: is_leading

    associate (terms => cluster%lifted_terms)
      is_leading = .true.
      do i = 1, size(terms)
        is_leading = is_leading .and. terms(i) == i
      end do
      if (is_leading) then
        call multiply(factor, a, theta(:size(terms)), 1.0_rk, y)
        return
      end if
      do i = 1, size(terms)
        call multiply(factor, a(:, i:i), theta(terms(i):terms(i)), 1.0_rk, y)
      end do
    end associate
  end subroutine add_lifted

  !> Openings of all contacts by the reduced displacement; is_known is false where the model lacks what they need. Nothing is
  !> allocated.
  subroutine fill_openings(cluster, theta, coordinates, opening, is_known)
    type(hhr_data_t), intent(in) :: cluster
    !> values of all terms
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] gamma, shape (n_modes)
    real(rk), contiguous, intent(in) :: coordinates(:)
    !> [length] shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    logical, intent(out) :: is_known
    integer :: i

    is_known = size(cluster%contact_gap, 2) == size(theta) .and. size(cluster%contact_value_basis, 1) == 2 * size(opening)
    if (.not. is_known) return
    call multiply(1.0_rk, cluster%contact_gap, theta, 0.0_rk, opening)
    do i = 1, size(coordinates)
      call add_opening(coordinates(i), cluster%contact_value_basis(:, i), opening)
    end do
    do i = 1, size(cluster%lifted_terms)
      call add_opening(theta(cluster%lifted_terms(i)), cluster%contact_value_lifting(:, i), opening)
    end do
  end subroutine fill_openings

  !> Adds what a displacement field opens: its normal displacements on the second surface minus those on the first one.
  pure subroutine add_opening(factor, field, opening)
    real(rk), intent(in) :: factor
    !> [length] first surface, then second surface, shape (2 n_multipliers)
    real(rk), contiguous, intent(in) :: field(:)
    !> [length] shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    integer :: i, n

    n = size(opening)
    do i = 1, n
      opening(i) = opening(i) + factor * (field(n + i) - field(i))
    end do
  end subroutine add_opening

  !> [force / length] K_r with these moduli, those that varying knows.
  pure function stiffness_at(cluster, moduli) result(stiffness)
    type(hhr_data_t), intent(in) :: cluster
    !> [force/length**2]
    real(rk), intent(in) :: moduli(:)
    !> shape (n_modes, n_modes)
    real(rk), allocatable :: stiffness(:, :)
    integer :: i

    stiffness = cluster%reduced_stiffness
    do i = 1, size(moduli)
      stiffness = stiffness + moduli(i) * reshape(cluster%varying%parts(:, i), shape(stiffness))
    end do
  end function stiffness_at
end module sig_hhr_data
