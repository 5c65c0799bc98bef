! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives with respect to the parameters through a history with friction: what is carried from one time to the next. They are
!> known as far as they were asked for at each time from the first one on; a step itself computes none.
module sig_friction_changes
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: friction_changes_t

  type :: friction_changes_t
    !> whether the derivatives of all earlier times are known
    logical :: are_known = .true.
    !> +1 or -1: the direction in which they were asked for
    integer :: direction = 1
    !> [length per unit of the parameter] of the origins of the present step, shape (n_unknowns, n_given); not allocated: they are
    !> zero
    real(rk), allocatable :: origins(:, :)
    !> whether the derivatives of an earlier time are one-sided, shape (n_given); not allocated: none is
    logical, allocatable :: is_one_sided(:)
    !> whether no step was made, and whether the derivatives of the present one were asked for
    logical, private :: is_new = .true.
    logical, private :: are_found = .false.
    !> what they leave to the next step
    integer, private :: next_direction = 1
    real(rk), allocatable, private :: next_origins(:, :)
    logical, allocatable, private :: next_one_sided(:)
  contains
    procedure :: begin
    procedure :: advance
    procedure :: fits
    procedure :: keep
  end type friction_changes_t

contains

  !> Begins a history: nothing has slipped yet, whatever the parameters are.
  pure subroutine begin(self)
    class(friction_changes_t), intent(inout) :: self

    self%are_known = .true.
    self%is_new = .true.
    self%are_found = .false.
    if (allocated(self%origins)) deallocate (self%origins, self%is_one_sided)
  end subroutine begin

  !> Goes on to a next step. Allocates nothing where no derivatives were asked for.
  pure subroutine advance(self)
    class(friction_changes_t), intent(inout) :: self

    self%are_known = self%are_known .and. (self%is_new .or. self%are_found)
    if (self%are_found) then
      self%direction = self%next_direction
      call move_alloc(self%next_origins, self%origins)
      call move_alloc(self%next_one_sided, self%is_one_sided)
    end if
    self%is_new = .false.
    self%are_found = .false.
  end subroutine advance

  !> Whether the derivatives of earlier times may be used for those in a direction: they are the same in both, or in this one.
  pure logical function fits(self, direction)
    class(friction_changes_t), intent(in) :: self
    integer, intent(in) :: direction

    fits = .true.
    if (allocated(self%is_one_sided)) fits = direction == self%direction .or. .not. any(self%is_one_sided)
  end function fits

  !> Keeps the derivatives of the present step for the next one. Requires: are_known.
  pure subroutine keep(self, origins, is_one_sided, direction)
    class(friction_changes_t), intent(inout) :: self
    !> [length per unit of the parameter] of the places of tangential rows, shape (n_unknowns, n_given)
    real(rk), intent(in) :: origins(:, :)
    logical, intent(in) :: is_one_sided(:)
    integer, intent(in) :: direction

    self%next_origins = origins
    self%next_one_sided = is_one_sided
    self%next_direction = direction
    self%are_found = .true.
  end subroutine keep
end module sig_friction_changes
