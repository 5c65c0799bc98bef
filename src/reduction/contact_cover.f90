! SPDX-License-Identifier: BSD-3-Clause
!> Finds contact rows that should be added to a reduced integration domain. Where no row of the domain is closed, the reduced model
!> answers without contact forces, even if contacts outside of the domain are closed.
module sig_contact_cover
  use sig_kinds, only: rk
  use sig_ties, only: first_largest
  implicit none(type, external)
  private
  public :: missing_rows, rows_next_to_close

  !> [-] a snapshot counts as seen by a row whose force is at least this fraction of the largest force of the snapshot
  real(rk), parameter :: noticeable = 1.0e-2_rk

contains

  !> Returns a few contact rows to add to a domain, so that each snapshot with contact forces has a noticeable force on some row of
  !> the domain: at least 1 % of the largest force of this snapshot. The rows are chosen one after the other. Each is the row with
  !> the largest sum of forces, relative to the largest force of their snapshot, over the snapshots that still have no such row,
  !> among the rows with a noticeable force in one of these; of nearly equal rows it is the first. The result is in the order of the
  !> choice, and empty where nothing is missing.
  pure function missing_rows(multipliers, domain_rows) result(rows)
    !> [force] shape (n_rows, n_snapshots)
    real(rk), intent(in) :: multipliers(:, :)
    !> rows that the domain has already, 1-based
    integer, intent(in) :: domain_rows(:)
    !> 1-based
    integer, allocatable :: rows(:)
    real(rk) :: shares(size(multipliers, 1), size(multipliers, 2))
    logical :: is_seen(size(multipliers, 2)), helps(size(multipliers, 1))
    integer :: i

    allocate (rows(0))
    do i = 1, size(is_seen)
      shares(:, i) = multipliers(:, i) / max(maxval(multipliers(:, i)), tiny(1.0_rk))
      is_seen(i) = .not. any(multipliers(:, i) > 0) .or. any(shares(domain_rows, i) >= noticeable)
    end do
    do while (.not. all(is_seen))
      ! many small forces may make the largest sum, and yet be noticeable in no snapshot
      helps = any(shares >= noticeable .and. spread(.not. is_seen, 1, size(shares, 1)), dim=2)
      associate (loads => sum(shares, dim=2, mask=spread(.not. is_seen, 1, size(shares, 1))))
        i = first_largest(merge(loads, 0.0_rk, helps))
      end associate
      rows = [rows, i]
      is_seen = is_seen .or. shares(i, :) >= noticeable
    end do
  end function missing_rows

  !> Returns for each snapshot the row with its smallest opening, where contact would begin; of nearly equal ones the first. Each
  !> row is listed once, in ascending order. Requires: at least one row.
  pure function rows_next_to_close(openings) result(rows)
    !> [length] opening of each contact row, shape (n_rows, n_snapshots)
    real(rk), intent(in) :: openings(:, :)
    integer, allocatable :: rows(:)
    logical :: is_next(size(openings, 1))
    integer :: i

    is_next = .false.
    do i = 1, size(openings, 2)
      is_next(first_largest(maxval(openings(:, i)) - openings(:, i))) = .true.
    end do
    rows = pack([(i, i=1, size(is_next))], is_next)
  end function rows_next_to_close
end module sig_contact_cover
