! SPDX-License-Identifier: BSD-3-Clause
!> Contact rows that a reduced integration domain lacks: a domain on which no row is closed answers without contact forces, whatever
!> happens elsewhere.
module sig_contact_cover
  use sig_kinds, only: rk
  use sig_ties, only: first_largest
  implicit none(type, external)
  private
  public :: missing_rows, rows_next_to_close

  !> [-] a force below this share of its snapshot's largest tells nothing of the others
  real(rk), parameter :: noticeable = 1.0e-2_rk

contains

  !> As few rows as give each snapshot with contact forces one that carries some: each time the row that carries most of the
  !> forces of those that still have none. Of equal ones the first. None where the domain sees all.
  pure function missing_rows(multipliers, domain_rows) result(rows)
    !> [force] shape (n_rows, n_snapshots)
    real(rk), intent(in) :: multipliers(:, :)
    !> 1-based
    integer, intent(in) :: domain_rows(:)
    integer, allocatable :: rows(:)
    real(rk) :: shares(size(multipliers, 1), size(multipliers, 2))
    logical :: is_seen(size(multipliers, 2))
    integer :: i

    allocate (rows(0))
    do i = 1, size(is_seen)
      shares(:, i) = multipliers(:, i) / max(maxval(multipliers(:, i)), tiny(1.0_rk))
      is_seen(i) = .not. any(multipliers(:, i) > 0) .or. any(shares(domain_rows, i) >= noticeable)
    end do
    do while (.not. all(is_seen))
      associate (loads => sum(shares, dim=2, mask=spread(.not. is_seen, 1, size(shares, 1))))
        i = first_largest(loads)
      end associate
      rows = [rows, i]
      is_seen = is_seen .or. shares(i, :) >= noticeable
    end do
  end function missing_rows

  !> The row of each snapshot that is nearest to touching, each once, ascending: where contact begins.
  pure function rows_next_to_close(openings) result(rows)
    !> [length] shape (n_rows, n_snapshots)
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
