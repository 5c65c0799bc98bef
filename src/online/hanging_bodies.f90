! SPDX-License-Identifier: BSD-3-Clause
!> Bodies that only contact holds, in a condensed problem: anchors, which are contacts that are taken as closed, hold them. To bound
!> the error of contact forces that another part found, these bodies must first be moved to a suitable place.
module sig_hanging_bodies
  use sig_force_balance, only: balance_forces, keep_balance
  use sig_kinds, only: rk
  use sig_linear_algebra, only: solve_dense
  implicit none(type, external)
  private
  public :: hanging_bodies_t

  type :: hanging_bodies_t
    private
    !> rows that are anchors (T), and the other rows
    integer, allocatable :: anchors(:)
    integer, allocatable :: others(:)
    !> [-] N: openings of the other rows per opening of each anchor, shape (n_others, n_anchors)
    real(rk), allocatable :: reach(:, :)
    !> [-] [N; 1]: work of each contact force on each free motion, shape (n_multipliers, n_anchors)
    real(rk), allocatable :: work(:, :)
    !> [length/force] scale of the anchors
    real(rk) :: scale = 1
  contains
    procedure :: create
    procedure :: are_balanced
    procedure :: settle
    procedure :: release
    procedure, private :: place
  end type hanging_bodies_t

contains

  !> Copies the data of the anchors.
  subroutine create(self, anchors, scale, work)
    class(hanging_bodies_t), intent(out) :: self
    !> rows that are anchors, 1-based
    integer, intent(in) :: anchors(:)
    !> [length/force] scale of the anchors
    real(rk), intent(in) :: scale
    !> [-] [N; 1], shape (n_multipliers, n_anchors)
    real(rk), intent(in) :: work(:, :)
    integer :: i

    self%anchors = anchors
    self%others = pack([(i, i=1, size(work, 1))], [(all(anchors /= i), i=1, size(work, 1))])
    self%scale = scale
    self%work = work
    self%reach = work(self%others, :)
  end subroutine create

  !> Whether forces balance the loads on the bodies that only contact holds, except for rounding.
  logical function are_balanced(self, free_opening, forces)
    class(hanging_bodies_t), intent(in) :: self
    !> q of the problem, shape (n_multipliers); its rows of the anchors are the work of the loads times
    !> `scale`
    real(rk), intent(in) :: free_opening(:)
    !> [force] >= 0 of all contacts, shape (n_multipliers)
    real(rk), intent(in) :: forces(:)

    are_balanced = keep_balance(self%work, free_opening(self%anchors) / self%scale, forces)
  end function are_balanced

  !> Moves the bodies that only contact holds, rigidly, to the place where the sum over all rows, with anchors, of force times
  !> squared opening is least, and computes the openings that the error bound needs (README). At this place rows with forces are
  !> nearly closed, and small forces hardly count. If the forces do not determine the place, all anchors stay closed. Any place
  !> gives a valid bound. The cost is n t^2 operations for n rows and t anchors.
  subroutine settle(self, forces, opening, surplus)
    class(hanging_bodies_t), intent(in) :: self
    !> [force] >= 0 of all contacts
    real(rk), intent(in) :: forces(:)
    !> [length] openings of the rows that are not anchors; in: C lambda + q, with closed anchors; out: C lambda + q + N (s - rho_T).
    !> s are the openings of the anchors at this place. rho_T is s for anchors with a force above s / `scale`, 0 for others
    real(rk), intent(inout) :: opening(:)
    !> [force*length] contribution of the anchors to the sum c of the bound
    real(rk), intent(out) :: surplus
    real(rk) :: s(size(self%anchors))
    logical :: is_held(size(s))

    associate (at_anchors => forces(self%anchors))
      s = self%place(forces, opening)
      is_held = at_anchors > s / self%scale
      ! rho_T is s for held anchors, else 0, as s is not negative there
      opening = opening + matmul(self%reach, merge(0.0_rk, max(s, 0.0_rk), is_held))
      surplus = sum(at_anchors * max(s, 0.0_rk), mask=.not. is_held)
    end associate
  end subroutine settle

  !> Returns the openings [length] of the anchors that make the sum of force times squared opening least. All are zero if the forces
  !> do not determine them, for example where no force acts on one of the bodies.
  function place(self, forces, opening) result(s)
    class(hanging_bodies_t), intent(in) :: self
    !> [force] >= 0 of all contacts
    real(rk), intent(in) :: forces(:)
    !> [length] openings of the other rows, with closed anchors
    real(rk), intent(in) :: opening(:)
    real(rk) :: s(size(self%anchors))
    real(rk) :: square(size(s), size(s)), pull(size(s))
    logical :: is_singular
    integer :: t

    associate (own => forces(self%others), at_anchors => forces(self%anchors))
      square = matmul(transpose(self%reach * spread(own, 2, size(s))), self%reach)
      do t = 1, size(s)
        square(t, t) = square(t, t) + at_anchors(t)
        pull(t) = -sum(self%reach(:, t) * own * opening)
      end do
      call solve_dense(square, pull, s, is_singular)
    end associate
  end function place

  !> Removes forces from contacts that are open at the place of the bodies (as in settle), and projects the others on the balance
  !> with the loads again. The first projection has distributed forces over all contacts, also over open ones, and each of these
  !> forces adds lambda w to the bound. A contact counts as open if its opening is at least its force times the diagonal of C (for
  !> an anchor: times `scale`). If the remaining forces cannot balance the loads, all forces stay.
  subroutine release(self, diagonal, opening, forces)
    class(hanging_bodies_t), intent(in) :: self
    !> [length/force] diagonal of C of the other rows
    real(rk), intent(in) :: diagonal(:)
    !> [length] openings of the other rows, C lambda + q with closed anchors
    real(rk), intent(in) :: opening(:)
    !> [force] >= 0 of all contacts, in balance
    real(rk), intent(inout) :: forces(:)
    real(rk) :: s(size(self%anchors))
    real(rk), allocatable :: rest(:)
    logical :: is_closed(size(forces)), is_balanced
    integer, allocatable :: rows(:)
    integer :: i

    s = self%place(forces, opening)
    is_closed(self%anchors) = forces(self%anchors) > s / self%scale
    is_closed(self%others) = forces(self%others) * diagonal > opening + matmul(self%reach, s)
    rows = pack([(i, i=1, size(forces))], is_closed)
    rest = forces(rows)
    call balance_forces(self%work(rows, :), matmul(forces, self%work), rest, is_balanced)
    if (.not. is_balanced) return
    forces = 0
    forces(rows) = rest
  end subroutine release
end module sig_hanging_bodies
