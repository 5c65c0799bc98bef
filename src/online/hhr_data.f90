! SPDX-License-Identifier: BSD-3-Clause
!> The data of a hyper-reduced model of one cluster of snapshots, (10). Training makes them and a file keeps them.
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

  !> Steps of Algorithm 1: the first entry has the modes without hat functions; one more entry follows per hat, in the order in
  !> which they joined. The reduced model of an entry has the modes and the hats up to this one.
  type :: enrichment_history_t
    !> multiplier whose contact carries the hat, 1-based among all multipliers; 0 for the first entry
    integer, allocatable :: rows(:)
    !> node of the hat, natural, 1-based; 0 for the first entry
    integer, allocatable :: nodes(:)
    !> number of POD modes and hats; with prescribed rows the basis has fewer columns
    integer, allocatable :: n_columns(:)
    !> rank of (11)
    integer, allocatable :: ranks(:)
    !> [-] kappa of (11), infinite if the rank is below the number of rows
    real(rk), allocatable :: condition_numbers(:)
    !> [-] largest over smallest of the min(rows, columns) singular values of the contact rows; Algorithm 1 reduces this ratio
    real(rk), allocatable :: singular_ratios(:)
    !> [-] condition number of K_r
    real(rk), allocatable :: stiffness_conditions(:)
  end type enrichment_history_t

  !> Hyper-reduced model of one cluster.
  !>
  !> u = lifting theta' + basis gamma with the lifted terms theta', those that prescribe displacements or impose strains;
  !> K_r gamma + M' lambda = load theta, M gamma <= gap theta, lambda >= 0 and complementary. Where the stiffness depends on the
  !> parameters, K_r and the load have further parts (varying).
  !> Source: (10). theta(n_terms) are the values of the model's terms. Numbers of nodes, cells and dofs are natural, 1-based.
  type :: hhr_data_t
    !> number of columns of the basis: first the POD modes that remain after prescribed rows are imposed, then the hats
    integer :: n_modes = 0
    !> number of POD modes that choose the domain (l of the paper), of further POD modes in the basis, and of hat functions
    integer :: n_pod_modes = 0
    integer :: n_extra_modes = 0
    integer :: n_hats = 0
    !> number of multipliers in the reduced integration domain
    integer :: n_rows = 0
    !> [-] V, shape (n_dofs, n_modes)
    real(rk), allocatable :: basis(:, :)
    !> [length per unit of theta] displacements of the lifted terms, shape (n_dofs, n_lifted_terms)
    real(rk), allocatable :: lifting(:, :)
    !> numbers of the lifted terms, 1-based; a term may occur twice; shape (n_lifted_terms)
    integer, allocatable :: lifted_terms(:)
    !> the parts that depend on the elastic constants, where these depend on the parameters
    type(hhr_stiffness_t) :: varying
    !> [force / length] K_r, neither symmetric nor definite, without the parts that vary; shape (n_modes, n_modes)
    real(rk), allocatable :: reduced_stiffness(:, :)
    !> [-] M, shape (n_rows, n_modes)
    real(rk), allocatable :: contact_matrix(:, :)
    !> [force per unit of theta] load without the parts that vary, shape (n_modes, n_terms)
    real(rk), allocatable :: load(:, :)
    !> [length per unit of theta] shape (n_rows, n_terms)
    real(rk), allocatable :: gap(:, :)
    !> rows that hold the rigid motions for which K_r has no stiffness (sig_hhr_system), 1-based among the n_rows
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
    !> training points whose snapshots the cluster has, 1-based, ascending
    integer, allocatable :: training_points(:)
    !> [force] multipliers of the snapshots, shape (n_multipliers, n_snapshots)
    real(rk), allocatable :: dual_snapshots(:, :)
    !> [length] normal displacements of the snapshots, first sides, then second sides, shape (n_contact_values, n_snapshots)
    real(rk), allocatable :: contact_displacement_snapshots(:, :)
    !> whether the reconstruction fits these displacements, too
    logical :: fits_displacements = .true.
    !> normal displacements of the basis [-], shape (n_contact_values, n_modes), and of the lifting [length per unit of theta],
    !> shape (n_contact_values, n_lifted_terms)
    real(rk), allocatable :: contact_value_basis(:, :)
    real(rk), allocatable :: contact_value_lifting(:, :)
    !> [length per unit of theta] initial gaps of all contacts, shape (n_multipliers, n_terms), or no columns
    real(rk), allocatable :: contact_gap(:, :)
    !> [-] closing of each contact by each rigid motion that only contact holds, shape (n_multipliers, n_motions)
    real(rk), allocatable :: motion_closing(:, :)
    !> [force per unit of theta] work of the loads on these motions, shape (n_terms, n_motions)
    real(rk), allocatable :: motion_load(:, :)
    !> data for error bounds where the matrix of all contacts is too large to keep
    type(lifted_data_t) :: certificate
    !> active sets of the reduced answers at the training points, as bits; a query starts from them. Shape (n_words(n_rows),
    !> n_points); without columns a query starts with the rows that penetrate
    integer, allocatable :: start_sets(:, :)
    !> [length] singular values, descending, of the snapshots; with elastic_lifting without their response without contact; [-] if
    !> the deck normalizes the snapshots
    real(rk), allocatable :: singular_values(:)
    !> [-] kappa of M, (11); infinite when rank < n_rows
    real(rk) :: condition_number = 1
    integer :: rank = 0
    !> [-] condition number of K_r, with springs on the anchors; in the middle of the parameter box if K_r depends on the parameters
    real(rk) :: stiffness_condition = 1
    !> rank of K_r, with springs on the anchors: number of modes that the equations determine
    integer :: stiffness_rank = 0
    !> rank of the basis on the domain: n_modes, unless columns depend on each other there
    integer :: basis_rank = 0
    !> the equations can determine at most as many modes: number of loaded, prescribed and contact dofs in the domain, plus number
    !> of hats; if the stiffness depends on the parameters, number of dofs with an equation, but at most n_modes
    integer :: primal_rank_expected = 0
    type(enrichment_history_t) :: history
    !> warnings of the training, one sentence each
    type(string_t), allocatable :: warnings(:)
  end type hhr_data_t

contains

  !> Allocates with size 0 each array of the cluster that is not allocated. An exception is lifted_terms: if not allocated, it
  !> becomes 1, 2, ..., one term for each column of the lifting. Requires: n_modes and n_rows are set.
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

  !> Computes y = y + factor * a theta' with the lifted terms. It allocates nothing, because queries call it.
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

  !> Computes the openings of all contacts by the reduced displacement. If the model lacks the data for this, is_known is false and
  !> `opening` stays unchanged. Nothing is allocated.
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

  !> Adds the openings that `factor` times a displacement field causes: its normal displacements on the second surface minus those
  !> on the first one.
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

  !> Returns K_r [force / length] for given moduli of `varying`.
  pure function stiffness_at(cluster, moduli) result(stiffness)
    type(hhr_data_t), intent(in) :: cluster
    !> [force/length**2] result of moduli_at, shape (n_moduli); empty: the result has no parts that vary
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
