! SPDX-License-Identifier: BSD-3-Clause
!> Checks whether a hyper-reduced model has one answer: ranks and condition numbers of its blocks, and warnings about them.
module sig_solvability
  use sig_condition_number, only: condition_number
  use sig_enrichment, only: largest_kappa
  use sig_kinds, only: rk
  use sig_linear_algebra, only: lu_t
  use sig_hhr_data, only: hhr_data_t, stiffness_at
  use sig_hhr_system, only: held_stiffness
  use sig_singular_values, only: singular_values, svd
  use sig_text, only: append_text, counted, lost_digits, short_number, string_t, to_text
  use sig_ties, only: first_largest
  implicit none(type, external)
  private
  public :: hang_bodies, measure_stiffness, rank_on_domain, is_undetermined, solvability_warnings, undetermined_text

  !> [-] above this condition number half of the digits of an answer may be lost
  real(rk), parameter :: large_condition = 1.0e8_rk

contains

  !> Measures the rank and the condition number of the reduced stiffness K_r: sets stiffness_rank, stiffness_condition and
  !> history%stiffness_conditions of `cluster`. The last are the condition numbers before the first hat and after each hat, those of
  !> the leading blocks of K_r, because hats are the last modes. A condition number is infinite where a singular value is exactly
  !> zero. Where K_r depends on the parameters, it is taken in the middle of the box.
  subroutine measure_stiffness(rank_tolerance, cluster)
    !> [-] a singular value below this times the largest counts as zero in the rank, not in the condition numbers
    real(rk), intent(in) :: rank_tolerance
    type(hhr_data_t), intent(inout) :: cluster
    real(rk), allocatable :: stiffness(:, :)
    real(rk) :: condition
    integer :: i, n, rank

    stiffness = reference_stiffness(cluster)

    if (allocated(cluster%history%stiffness_conditions)) deallocate (cluster%history%stiffness_conditions)
    allocate (cluster%history%stiffness_conditions(cluster%n_hats + 1))
    do i = 1, cluster%n_hats + 1
      n = cluster%n_modes - cluster%n_hats + i - 1
      ! without tolerance: a finite number for all but exact zeros
      call condition_number(stiffness(:n, :n), 0.0_rk, cluster%history%stiffness_conditions(i), rank)
    end do
    cluster%stiffness_condition = cluster%history%stiffness_conditions(cluster%n_hats + 1)
    call condition_number(stiffness, rank_tolerance, condition, cluster%stiffness_rank)
  end subroutine measure_stiffness

  !> Returns K_r; where it depends on the parameters, that in the middle of the box.
  pure function reference_stiffness(cluster) result(stiffness)
    type(hhr_data_t), intent(in) :: cluster
    real(rk), allocatable :: stiffness(:, :)

    stiffness = cluster%reduced_stiffness
    if (cluster%varying%is_there()) stiffness = stiffness_at(cluster, cluster%varying%reference)
  end function reference_stiffness

  !> Sets cluster%anchors: contact rows, as positions among those of the domain, that hold the rigid motions for which K_r has no
  !> stiffness, those of bodies that only contact holds. stiffness_rank and stiffness_condition are then measured again, with these
  !> rows as constraints. There are no anchors, and nothing else changes, where K_r has full rank, where it lacks more ranks than
  !> n_free or than there are rows, or where the rows cannot hold the motions. Requires: measure_stiffness.
  subroutine hang_bodies(n_free, rank_tolerance, cluster)
    !> number of rigid motions that only contact holds
    integer, intent(in) :: n_free
    !> [-] as in measure_stiffness; a row whose openings under these motions are at most this times its size in contact_matrix holds
    !> none of them. With anchors, smaller singular values count as zero in the condition number, too (then infinite)
    real(rk), intent(in) :: rank_tolerance
    type(hhr_data_t), intent(inout) :: cluster
    real(rk), allocatable :: direction(:), reach(:, :), s(:), u(:, :), vt(:, :)
    logical :: is_anchor(cluster%n_rows)
    integer :: i, k, n_missing

    cluster%anchors = [integer ::]
    n_missing = cluster%n_modes - cluster%stiffness_rank
    if (n_missing == 0 .or. n_missing > min(n_free, cluster%n_rows)) return
    call svd(reference_stiffness(cluster), u, s, vt)
    ! opening of each row under the motions without stiffness
    reach = matmul(cluster%contact_matrix, transpose(vt(cluster%stiffness_rank + 1:, :)))
    is_anchor = .false.
    do k = 1, n_missing
      i = first_largest(sum(reach**2, dim=2))
      if (sum(reach(i, :)**2) <= rank_tolerance**2 * sum(cluster%contact_matrix(i, :)**2)) return
      is_anchor(i) = .true.
      direction = reach(i, :) / norm2(reach(i, :))
      reach = reach - spread(matmul(reach, direction), 2, n_missing) * spread(direction, 1, cluster%n_rows)
    end do
    cluster%anchors = pack([(i, i=1, cluster%n_rows)], is_anchor)
    call condition_number(held_stiffness(cluster, reference_stiffness(cluster)), rank_tolerance, cluster%stiffness_condition, &
      cluster%stiffness_rank)
  end subroutine hang_bodies

  !> Returns the rank of the basis on the dofs of the domain. The columns are first scaled to length 1 there.
  !>
  !> Source: remark at the end of section 3.4: the modes with hats must be independent on the domain.
  integer function rank_on_domain(basis, dofs, rank_tolerance) result(rank)
    !> shape (n_dofs, n_modes)
    real(rk), intent(in) :: basis(:, :)
    !> dofs of the domain, natural (order of the mesh file)
    integer, intent(in) :: dofs(:)
    !> [-] singular values below this times the largest count as zero
    real(rk), intent(in) :: rank_tolerance
    real(rk), allocatable :: columns(:, :), sigma(:)
    integer :: i

    columns = basis(dofs, :)
    do i = 1, size(columns, 2)
      if (norm2(columns(:, i)) > 0) columns(:, i) = columns(:, i) / norm2(columns(:, i))
    end do
    rank = 0
    sigma = singular_values(columns)
    if (size(sigma) > 0) rank = count(sigma > 0 .and. sigma >= rank_tolerance * sigma(1))
  end function rank_on_domain

  !> Whether the equations do not determine all modes, so that answers of the model would be arbitrary.
  !>
  !> That is the case where K_r, held by the anchors if there are any, is numerically singular; without hats also where its rank by
  !> the tolerance is not full. With hats the rank does not count, because hats make K_r badly conditioned. Requires:
  !> measure_stiffness.
  logical function is_undetermined(cluster)
    type(hhr_data_t), intent(in) :: cluster
    real(rk), allocatable :: stiffness(:, :)
    type(lu_t) :: lu

    stiffness = reference_stiffness(cluster)
    if (allocated(cluster%anchors)) stiffness = held_stiffness(cluster, stiffness)
    call lu%factor(stiffness)
    is_undetermined = lu%is_singular .or. (cluster%n_hats == 0 .and. cluster%stiffness_rank < cluster%n_modes)
  end function is_undetermined

  !> Returns a sentence without full stop with three numbers: of the modes that the equations determine, of all modes, and of the
  !> modes that they can determine at most.
  function undetermined_text(cluster) result(text)
    type(hhr_data_t), intent(in) :: cluster
    character(:), allocatable :: text

    text = 'the equations of the reduced integration domain determine ' // to_text(cluster%stiffness_rank) // ' of ' // &
      counted(cluster%n_modes, 'mode') // ' (they can determine at most ' // to_text(cluster%primal_rank_expected) // ')'
  end function undetermined_text

  !> Returns the warnings about a model, one sentence each, without full stop: ranks that are not full (of (11), of the basis on the
  !> domain, of K_r), loads that the equations of the domain do not see, a condition number of K_r above 1e8, has_all_hats.
  !> Requires: the ranks and condition numbers in `cluster`.
  function solvability_warnings(cluster, has_all_hats, n_loaded, n_missed) result(warnings)
    type(hhr_data_t), intent(in) :: cluster
    !> the deck asks for the hats of both sides (reduction.enrichment: all)
    logical, intent(in) :: has_all_hats
    !> number of loaded nodes (find_loaded_nodes), and of those among them that are not interior nodes of the domain
    integer, intent(in) :: n_loaded
    integer, intent(in) :: n_missed
    type(string_t), allocatable :: warnings(:)

    allocate (warnings(0))
    if (cluster%rank < cluster%n_rows) call append_text(warnings, 'the solvability condition (11) fails: rank ' // &
      to_text(cluster%rank) // ' of ' // counted(cluster%n_rows, 'contact row') // '; multipliers may not be unique ' // &
      '(more hat functions may help: reduction.enrichment: auto or greedy, with max_hats large enough)')
    if (cluster%rank == cluster%n_rows .and. cluster%condition_number > largest_kappa) call append_text(warnings, &
      'the condition number of the contact rows is ' // short_number(cluster%condition_number) // ': multipliers may lose about ' &
      // lost_digits(cluster%condition_number) // ' (more hat functions may help: reduction.enrichment: auto or greedy)')
    if (cluster%basis_rank < cluster%n_modes) call append_text(warnings, 'on the reduced integration domain ' // &
      to_text(cluster%n_modes - cluster%basis_rank) // ' of ' // to_text(cluster%n_modes) // ' modes depend on the others')
    if (cluster%stiffness_rank < cluster%n_modes) call append_text(warnings, undetermined_text(cluster))
    if (n_missed > 0) call append_text(warnings, 'the equations of the reduced integration domain do not see the load on ' // &
      to_text(n_missed) // ' of ' // counted(n_loaded, 'loaded node') // &
      ' (auto in reduction.zones_of_interest adds these nodes to the domain)')
    if (cluster%stiffness_condition > large_condition) call append_text(warnings, &
      'the condition number of the reduced stiffness is ' // short_number(cluster%stiffness_condition) // &
      ': answers may lose about ' // lost_digits(cluster%stiffness_condition))
    if (has_all_hats) call append_text(warnings, 'the hats of both sides of the contacts are in the basis: the contact rows ' // &
      'are conditioned best, but the equations of the reduced integration domain hardly determine the answer; ' // &
      'reduction.enrichment: greedy takes at most one hat per contact')
  end function solvability_warnings
end module sig_solvability
