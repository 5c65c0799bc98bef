! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Compresses the displacements H of all dofs under unit contact forces, group by group of near contacts, and computes what they are
!> wrong by in the norm of K.
!>
!> Columns of a soft body are large, smooth and much alike, and the rounding of single precision, which is rough, is then large
!> beside them in the norm of K. So a few modes Phi may take what is soft out of H, and what is compressed is R = H - Phi A.
!>
!> With the errors E = R~ - R of the compressed columns R~, the error of a displacement H z is known: z'(E'K E) z. While group J is
!> compressed, R_J is there, but R_I of an earlier group is no longer. As K H_I = B_I' on free dofs, where E is zero elsewhere,
!> E_I'K E_J = R~_I'(K E_J) - B_I E_J + A_I'Phi'(K E_J). With anchors T, whose forces balance B_I', it is (B - N B_T) E_J in place
!> of B E_J.
module sig_response_compression
  use sig_block_compression, only: blocks_of, compress_columns, piece_t
  use sig_bodies, only: find_bodies
  use sig_compressed_matrix, only: block_entries, compressed_matrix_t
  use sig_condensed, only: condensed_t
  use sig_contact_field, only: contact_field_t
  use sig_contact_responses, only: close_rows
  use sig_contact_states, only: contact_states_t
  use sig_contact_system, only: contact_system_t
  use sig_dense_kernels, only: factor_cholesky
  use sig_energy_modes, only: choose_combinations, product_of
  use sig_kinds, only: rk, sk
  use sig_linear_algebra, only: transposed_product
  use sig_petsc_support, only: broadcast_integers, broadcast_singles, multiply_block, rank_and_size, &
    sum_over_ranks
  use sig_point_tree, only: point_tree_t
  use sig_problem, only: problem_t
  use sig_progress, only: progress_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_rounding, only: rounding
  use petsc
  implicit none(type, external)
  private
  public :: choose_soft_combinations, compress_responses, group_contacts

  !> How the rows of H are ordered and scaled.
  type :: row_layout_t
    type(point_tree_t) :: nodes
    integer :: n_components = 0
    !> natural dof of each ordered row, shape (n_dofs)
    integer, allocatable :: dofs(:)
    !> [sqrt(force/length)] roots of the diagonal of K in natural order: an error of H, scaled by them, has about its size in the
    !> norm of K
    real(rk), allocatable :: scale(:)
  end type row_layout_t

  !> columns of a group
  integer, parameter :: group_size = 64
  !> points of a leaf of the tree of nodes
  integer, parameter :: leaf_size = 32
  !> [s] progress is told only if compression takes longer
  real(rk), parameter :: seconds_of_silence = 3
  !> The error of a group is about in proportion to the threshold of its blocks, so that a second attempt nearly always reaches it.
  integer, parameter :: most_attempts = 3
  integer, parameter :: n_soft_modes = 10
  !> [-] of the columns, whose part in the displacement is not known before: the first group finds the one that suits
  real(rk), parameter :: first_threshold = 0.1_rk
  !> [-] below this there is only the rounding of single precision
  real(rk), parameter :: least_threshold = real(epsilon(1.0_sk), rk)
  !> [-] share of the wanted error at which a new threshold aims
  real(rk), parameter :: safety = 0.7_rk
  !> [-] largest growth of the threshold from one group to the next
  real(rk), parameter :: most_growth = 2

contains

  !> Finds combinations S of contact forces whose displacements H S are the soft motions of H, orthonormal in the norm of K: those
  !> by forces that are as large as the closings by one contact of each group. Local, with the same result on each rank.
  subroutine choose_soft_combinations(problem, fixed, combinations)
    type(problem_t), intent(in) :: problem
    type(fixed_compliance_t), intent(in) :: fixed
    !> [force/sqrt(force*length)] S, shape (n_multipliers, n_modes)
    real(rk), allocatable, intent(out) :: combinations(:, :)
    integer, allocatable :: ends(:), order(:)
    real(rk), allocatable :: closings(:, :)
    integer :: i

    call group_contacts(problem, fixed%anchors, order, ends)
    closings = fixed%compliance(:, [(order((ends(max(1, i - 1)) + ends(i)) / 2), i=1, size(ends))])
    closings(fixed%anchors, :) = 0
    call choose_combinations(closings, fixed%compliance, combinations)
    combinations = combinations(:, :min(n_soft_modes, size(combinations, 2)))
  end subroutine choose_soft_combinations

  !> Compresses what the modes of the field leave of H so that the error of each state is nearly `tolerance` or less. Only needed
  !> modes stay. Collective on all ranks, with the same result on each.
  !>
  !> Errors of different groups hardly add up in one direction, so that each group gets the tolerance over the root of the largest
  !> number of groups that have forces at once.
  !> The caller asks the field for the error of a state (contact_field_t%error_of), and comes back with a smaller tolerance if it is
  !> too large.
  subroutine compress_responses(problem, system, condensed, states, tolerance, fixed, ierr)
    type(problem_t), intent(in) :: problem
    type(contact_system_t), intent(inout) :: system
    type(condensed_t), intent(inout) :: condensed
    type(contact_states_t), intent(in) :: states
    !> [-] relative to the sizes of the states
    real(rk), intent(in) :: tolerance
    !> its field has modes and gets the compressed responses and their errors
    type(fixed_compliance_t), intent(inout) :: fixed
    PetscErrorCode, intent(out) :: ierr
    type(compressed_matrix_t), allocatable :: groups(:)
    type(row_layout_t) :: layout
    type(progress_t) :: progress
    real(rk), allocatable :: errors(:, :), forces(:, :), products(:, :), wrong(:, :), wrong_forces(:, :)
    integer, allocatable :: ends(:), order(:), own(:)
    real(rk) :: share, threshold
    integer :: first, i

    PetscCall(lay_out_rows(problem, system, layout, ierr))
    call keep_soft_modes(states, layout%scale, tolerance, fixed%field)
    call group_contacts(problem, fixed%anchors, order, ends)
    allocate (groups(size(ends)), errors(size(order), size(order)))
    share = tolerance / sqrt(real(max(1, most_loaded(order, ends, states%unknowns)), rk))
    threshold = first_threshold
    first = 1
    call progress%start('compressed responses to contact forces', size(order), seconds_of_silence)
    do i = 1, size(groups)
      own = order(first:ends(i))
      forces = states%unknowns(own, :) / spread(states%sizes, 1, size(own))
      call compress_group(system, condensed, layout, own, forces, share, fixed, threshold, groups(i), wrong, wrong_forces, ierr)
      CHKERRQ(ierr)
      associate (rows => order(:ends(i)))
        call find_products(system, condensed, layout, groups(:i), rows, fixed%field, wrong, wrong_forces, products, ierr)
        CHKERRQ(ierr)
      end associate
      errors(:ends(i), first:ends(i)) = products
      errors(first:ends(i), :first - 1) = transpose(errors(:first - 1, first:ends(i)))
      first = ends(i) + 1
      call progress%advance(ends(i))
    end do
    call progress%finish()
    associate (responses => fixed%field%responses)
      responses%row_order = layout%dofs
      ! anchors have no blocks
      responses%column_order = [order, fixed%anchors]
      call responses%join_columns(groups)
    end associate
    call take_errors(order, errors, fixed%field)
    PetscCall(agree(fixed%field, ierr))
  end subroutine compress_responses

  !> Keeps only those first modes without which the rounding of single precision is felt in some state. Rounding of the columns A_mk
  !> Phi_m of a mode is not the same in any two of them, so that it leaves in a state, relative to its size,
  !>
  !>     |Phi_m|_diag(K) epsilon / 4 sqrt(sum over k of (z_k A_mk)**2)
  !>
  !> Local, with the same result on each rank.
  subroutine keep_soft_modes(states, scale, tolerance, field)
    type(contact_states_t), intent(in) :: states
    !> [sqrt(force/length)] roots of the diagonal of K
    real(rk), intent(in) :: scale(:)
    !> [-]
    real(rk), intent(in) :: tolerance
    !> in: principal modes, largest first
    type(contact_field_t), intent(inout) :: field
    real(rk), parameter :: unfelt = 0.1_rk, mean_rounding = real(epsilon(1.0_sk), rk) / 4
    real(rk) :: squares(size(states%sizes))
    integer :: m

    squares = 0
    do m = size(field%modes, 2), 1, -1
      squares = squares + (mean_rounding * norm2(scale * field%modes(:, m)) / states%sizes)**2 * &
        matmul(field%coordinates(m, :)**2, states%unknowns**2)
      if (any(squares > (unfelt * tolerance)**2)) exit
    end do
    field%modes = field%modes(:, :m)
    field%coordinates = field%coordinates(:m, :)
  end subroutine keep_soft_modes

  !> Divides the contacts that are not anchors into groups of near ones. Local.
  subroutine group_contacts(problem, anchors, order, ends)
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: anchors(:)
    !> the contacts, group by group
    integer, allocatable, intent(out) :: order(:)
    !> place of the last contact of each group in `order`
    integer, allocatable, intent(out) :: ends(:)
    type(point_tree_t) :: contacts
    integer, allocatable :: rows(:)
    real(rk), allocatable :: places(:, :)
    integer :: i

    rows = pack([(i, i=1, problem%force_rows%n_rows)], [(all(anchors /= i), i=1, problem%force_rows%n_rows)])
    allocate (places(problem%mesh%n_dim, size(rows)))
    do i = 1, size(rows)
      places(:, i) = problem%mesh%coordinates(:, minval(problem%force_rows%first_nodes_of(rows(i))))
    end do
    call contacts%create(places, [(1, i=1, size(rows))], group_size)
    order = rows(contacts%order)
    ends = pack(contacts%last, contacts%children(1, :) == 0)
  end subroutine group_contacts

  !> Returns the largest number of groups that have forces in one state.
  pure integer function most_loaded(order, ends, unknowns)
    !> of group_contacts
    integer, intent(in) :: order(:)
    integer, intent(in) :: ends(:)
    !> shape (n_multipliers, n_states)
    real(rk), intent(in) :: unknowns(:, :)
    logical :: is_loaded(size(ends), size(unknowns, 2))
    integer :: first, i

    first = 1
    do i = 1, size(ends)
      is_loaded(i, :) = any(abs(unknowns(order(first:ends(i)), :)) > 0, dim=1)
      first = ends(i) + 1
    end do
    most_loaded = maxval([0, count(is_loaded, dim=1)])
  end function most_loaded

  !> Orders the nodes, body by body, so that near ones stand together. Collective.
  subroutine lay_out_rows(problem, system, layout, ierr)
    type(problem_t), intent(in) :: problem
    type(contact_system_t), intent(inout) :: system
    type(row_layout_t), intent(out) :: layout
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: body_of_node(:)
    integer :: i, k, n_bodies

    call find_bodies(problem%mesh, body_of_node, n_bodies)
    call layout%nodes%create(problem%mesh%coordinates, body_of_node, leaf_size)
    layout%n_components = problem%mesh%n_dim
    associate (n => layout%n_components, order => layout%nodes%order)
      layout%dofs = [((n * (order(i) - 1) + k, k=1, n), i=1, size(order))]
    end associate
    allocate (layout%scale(system%map%n_dofs))
    PetscCall(MatGetDiagonal(system%stiffness, system%work_out, ierr))
    PetscCall(system%get(system%work_out, layout%scale, ierr))
    layout%scale = sqrt(layout%scale)
  end subroutine lay_out_rows

  !> Compresses the columns of one group J so that its part of the error of each state is at most `tolerance`, if single precision
  !> allows it. With R_J'K R_J = C_JJ - A_J'A_J = L L', the columns R_J L'^-1 are orthonormal in the norm of K, so that a threshold
  !> for them is one for relative errors in this norm. Collective.
  subroutine compress_group(system, condensed, layout, rows, forces, tolerance, fixed, threshold, matrix, errors, &
    error_forces, ierr)
    type(contact_system_t), intent(in) :: system
    type(condensed_t), intent(inout) :: condensed
    type(row_layout_t), intent(in) :: layout
    !> J
    integer, intent(in) :: rows(:)
    !> contact forces z_J of the states relative to their sizes, shape (size(rows), n_states)
    real(rk), intent(in) :: forces(:, :)
    !> [-]
    real(rk), intent(in) :: tolerance
    !> with C, Phi and A
    type(fixed_compliance_t), intent(in) :: fixed
    !> [-] largest error in a leaf of the tree; becomes the one that suits the next group
    real(rk), intent(inout) :: threshold
    !> R~_J
    type(compressed_matrix_t), intent(out) :: matrix
    !> [length/force] E_J, and K E_J, rows of this rank
    real(rk), allocatable, intent(out) :: errors(:, :)
    real(rk), allocatable, intent(out) :: error_forces(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(piece_t), allocatable :: pieces(:)
    real(rk), allocatable :: columns(:, :), factor(:, :), own(:, :), places(:, :), scaled(:, :)
    real(rk) :: error
    integer :: i

    allocate (own(system%map%n_local_dofs, size(rows)))
    PetscCall(condensed%respond_to_rows(system, rows, own, ierr))
    places = fixed%field%coordinates(:, rows)
    own = own - product_of(fixed%field%modes(system%map%local_dofs, :), places)
    PetscCall(system%share_columns(own, size(rows), columns, ierr))
    columns = columns(layout%dofs, :)
    call factor_group(fixed%compliance(rows, rows), places, factor)
    scaled = columns * spread(layout%scale(layout%dofs), 2, size(rows))
    call divide_by_factor(factor, scaled)
    allocate (error_forces, mold=own)
    do i = 1, most_attempts
      call compress_columns(layout%nodes, layout%n_components, scaled, threshold, pieces)
      matrix = blocks_of(layout%nodes, pieces, columns, 1 / layout%scale(layout%dofs), transpose(factor))
      errors = matrix%full_matrix()
      errors(layout%dofs, :) = errors
      errors = errors(system%map%local_dofs, :) - own
      PetscCall(multiply_block(system%stiffness, errors, error_forces, ierr))
      PetscCall(measure_states(system, errors, error_forces, forces, error, ierr))
      if (error <= tolerance .or. threshold <= least_threshold) exit
      threshold = max(least_threshold, threshold * safety * tolerance / error)
    end do
    threshold = threshold * min(most_growth, max(1.0_rk, safety * tolerance / max(error, tiny(error))))
  end subroutine compress_group

  !> Factors C_JJ - A_J'A_J = L L'. If it is not positive definite, as where two rows do the same, a little is added to its
  !> diagonal, until it is.
  subroutine factor_group(compliance, places, factor)
    !> C_JJ
    real(rk), intent(in) :: compliance(:, :)
    !> A_J
    real(rk), intent(in) :: places(:, :)
    !> L, zero above the diagonal
    real(rk), allocatable, intent(out) :: factor(:, :)
    real(rk), allocatable :: left(:, :)
    real(rk) :: added, largest
    integer :: i, info, n

    n = size(compliance, 1)
    left = compliance - transposed_product(places, places)
    ! what the modes take completely is rounding
    largest = max(maxval([(left(i, i), i=1, n)]), rounding * maxval([(compliance(i, i), i=1, n)]))
    added = 0
    do
      factor = left
      do i = 1, n
        factor(i, i) = factor(i, i) + added * largest
      end do
      call factor_cholesky(n, factor, info)
      if (info == 0) exit
      added = max(10 * added, 100 * epsilon(added))
    end do
    do i = 2, n
      factor(:i - 1, i) = 0
    end do
  end subroutine factor_group

  !> Multiplies each row by L'^-1 from the right.
  subroutine divide_by_factor(factor, rows)
    !> L, lower triangle
    real(rk), intent(in) :: factor(:, :)
    !> shape (n_rows, n)
    real(rk), intent(inout) :: rows(:, :)
    integer :: i, k

    do i = 1, size(factor, 1)
      do k = 1, i - 1
        rows(:, i) = rows(:, i) - factor(i, k) * rows(:, k)
      end do
      rows(:, i) = rows(:, i) / factor(i, i)
    end do
  end subroutine divide_by_factor

  !> [-] Measures the largest error |E z|_K of the states. Collective.
  subroutine measure_states(system, errors, error_forces, forces, error, ierr)
    type(contact_system_t), intent(in) :: system
    !> E, and K E, rows of this rank
    real(rk), intent(in) :: errors(:, :)
    real(rk), intent(in) :: error_forces(:, :)
    !> z of the states relative to their sizes
    real(rk), intent(in) :: forces(:, :)
    real(rk), intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: square(:, :)

    square = transposed_product(errors, error_forces)
    PetscCall(sum_over_ranks(system%comm, square, ierr))
    error = sqrt(maxval([0.0_rk, sum(forces * product_of(square, forces), dim=1)]))
  end subroutine measure_states

  !> Computes E_I'K E_J for the last group J and for all groups I up to it. Each rank does some of these. Collective.
  subroutine find_products(system, condensed, layout, groups, rows, field, errors, error_forces, products, ierr)
    type(contact_system_t), intent(in) :: system
    type(condensed_t), intent(in) :: condensed
    type(row_layout_t), intent(in) :: layout
    !> R~_I
    type(compressed_matrix_t), intent(in) :: groups(:)
    !> contacts of the groups
    integer, intent(in) :: rows(:)
    !> with Phi and A
    type(contact_field_t), intent(in) :: field
    !> E_J, and K E_J, rows of this rank
    real(rk), contiguous, intent(in) :: errors(:, :)
    real(rk), contiguous, intent(in) :: error_forces(:, :)
    !> [length/force] shape (size(rows), size(errors, 2))
    real(rk), allocatable, intent(out) :: products(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: closing(:, :), forces(:, :), places(:, :)
    integer :: first, i, last, n_ranks, rank

    PetscCall(rank_and_size(system%comm, rank, n_ranks, ierr))
    PetscCall(system%share_columns(error_forces, size(error_forces, 2), forces, ierr))
    forces = forces(layout%dofs, :)
    PetscCall(close_rows(system, errors, closing, ierr))
    associate (anchors => condensed%anchors)
      if (size(anchors%rows) > 0) closing = closing - matmul(anchors%closing, closing(anchors%rows, :))
    end associate
    ! Phi'(K E_J)
    places = transposed_product(field%modes(layout%dofs, :), forces)
    allocate (products(size(rows), size(errors, 2)), source=0.0_rk)
    last = 0
    do i = 1, size(groups)
      first = last + 1
      last = last + size(groups(i)%column_order)
      if (modulo(i, n_ranks) == rank) &
        products(first:last, :) = groups(i)%transposed_product(forces) - closing(rows(first:last), :) + &
          transposed_product(field%coordinates(:, rows(first:last)), places)
    end do
    PetscCall(sum_over_ranks(system%comm, products, ierr))
  end subroutine find_products

  !> Sets field%errors. Local.
  subroutine take_errors(order, errors, field)
    !> contact of each row of `errors`
    integer, intent(in) :: order(:)
    !> E'K E
    real(rk), intent(in) :: errors(:, :)
    type(contact_field_t), intent(inout) :: field
    real(rk), allocatable :: all_errors(:, :)
    integer :: i, n

    n = size(field%responses%column_order)
    allocate (all_errors(n, n), source=0.0_rk)
    all_errors(order, order) = errors
    field%errors = [(real(all_errors(i:, i), sk), i=1, n)]
  end subroutine take_errors

  !> Gives every rank the compressed responses of the first rank, because groups of ranks compress on their own and may differ by
  !> rounding. Collective on all ranks.
  subroutine agree(field, ierr)
    type(contact_field_t), intent(inout) :: field
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: blocks(:)

    blocks = [field%responses%blocks]
    PetscCall(broadcast_integers(blocks, PETSC_COMM_WORLD, ierr))
    field%responses%blocks = reshape(blocks, [block_entries, size(blocks) / block_entries])
    PetscCall(broadcast_singles(field%responses%values, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_singles(field%errors, PETSC_COMM_WORLD, ierr))
  end subroutine agree
end module sig_response_compression
