! SPDX-License-Identifier: BSD-3-Clause
!> Bodies that only contact holds and no load moves, as at the end of an unloading. Without forces on them there is equilibrium, but
!> their place is not unique, and no method that follows forces finds one.
module sig_friction_rest
  use sig_friction_types, only: friction_contacts_t
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t, solve_lcp
  use sig_reasons, only: reason_converged
  implicit none(type, external)
  private
  public :: find_unloaded, place_unloaded

  !> [-] openings by a motion are rounding below this share of the largest one
  real(rk), parameter :: rounding_of_motions = 1.0e-10_rk

contains

  !> Finds bodies without loads. Motions that open the same contact belong together: all of them must be without loads, and all
  !> their contacts without tied surfaces.
  pure subroutine find_unloaded(matrix, loads, contacts, is_unloaded, is_theirs)
    !> [length/force] W as in solve_friction
    real(rk), contiguous, intent(in) :: matrix(:, :)
    !> [length] q in the rows of motions: exactly zero where it is only rounding; shape (n_motions)
    real(rk), intent(in) :: loads(:)
    type(friction_contacts_t), intent(in) :: contacts
    !> whether a motion is one of such a body, shape (n_motions)
    logical, intent(out) :: is_unloaded(:)
    !> whether a contact touches such a body, shape (n_contacts)
    logical, intent(out) :: is_theirs(:)
    logical :: moves(contacts%n_motions, contacts%n_contacts)
    integer :: group(contacts%n_motions)
    real(rk) :: least
    integer :: j, k

    group = [(j, j=1, contacts%n_motions)]
    associate (n => contacts%n_forces())
      least = rounding_of_motions * maxval(abs(matrix(:n, n + 1:)))
      do k = 1, contacts%n_contacts
        moves(:, k) = any(abs(matrix(contacts%rows_of(k), n + 1:)) > least, dim=1)
        if (any(moves(:, k))) group = merge(minval(group, mask=moves(:, k)), group, in_groups(group, moves(:, k)))
      end do
    end associate
    is_unloaded = .true.
    do j = 1, size(group)
      if (abs(loads(j)) > 0) where (group == group(j)) is_unloaded = .false.
    end do
    do k = 1, contacts%n_contacts
      if (contacts%is_tied(k)) where (in_groups(group, moves(:, k))) is_unloaded = .false.
    end do
    is_theirs = [(any(moves(:, k) .and. is_unloaded), k=1, contacts%n_contacts)]
  end subroutine find_unloaded

  !> Returns which motions are in the groups of some of them.
  pure function in_groups(group, some)
    integer, intent(in) :: group(:)
    logical, intent(in) :: some(:)
    logical :: in_groups(size(group))
    integer :: j

    in_groups = [(any(some .and. group == group(j)), j=1, size(group))]
  end function in_groups

  !> Moves bodies without loads as little as possible, until nothing overlaps: min |a - a_0|^2 with w + N (a - a_0) >= 0. Its
  !> multipliers l >= 0 give a = a_0 + N' l.
  subroutine place_unloaded(gaps, by_motions, motions, is_placed)
    !> [length] w of their contacts, with the bodies at a_0; shape (n)
    real(rk), intent(in) :: gaps(:)
    !> [length/force] N, shape (n, n_motions)
    real(rk), intent(in) :: by_motions(:, :)
    !> [force] in: a_0; out: a; shape (n_motions)
    real(rk), intent(inout) :: motions(:)
    !> whether there is such a place
    logical, intent(out) :: is_placed
    type(lcp_solution_t) :: solution
    real(rk) :: largest
    logical, parameter :: cold(0) = .true.

    largest = maxval([0.0_rk, abs(by_motions)])
    is_placed = largest > 0
    if (.not. is_placed) return
    call solve_lcp(matmul(by_motions / largest, transpose(by_motions / largest)), gaps, cold, solution)
    is_placed = solution%reason == reason_converged
    if (is_placed) motions = motions + matmul(solution%lambda / largest, by_motions / largest)
  end subroutine place_unloaded
end module sig_friction_rest
