! SPDX-License-Identifier: BSD-3-Clause
!> The work arrays of a model's parts for one thread. Those of a part are made before its first answer.
module sig_rooms
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_reduced, only: room_t
  implicit none(type, external)
  private
  public :: rooms_t

  type :: room_box_t
    class(room_t), allocatable :: room
  end type room_box_t

  type :: rooms_t
    !> shape (n_parts)
    type(room_box_t), allocatable :: of_part(:)
  contains
    procedure :: enter
    procedure :: begin_step
    procedure :: forget
    procedure :: leave_out_points
    procedure :: save_memory
    procedure :: restore_memory
  end type rooms_t

contains

  !> Makes the work arrays (the room) of part i of the model. It does nothing if they are there already.
  subroutine enter(self, model, i)
    class(rooms_t), intent(inout) :: self
    !> the model, after prepare of sig_online_model
    type(model_t), intent(in) :: model
    !> number of the part, 1-based
    integer, intent(in) :: i

    if (.not. allocated(self%of_part)) allocate (self%of_part(size(model%parts)))
    if (.not. allocated(self%of_part(i)%room)) call model%parts(i)%reduced%create_room(self%of_part(i)%room)
  end subroutine enter

  !> Gives all parts the numbers of the next state and the length of its step (begin_step of sig_reduced).
  subroutine begin_step(self, model, state, dt)
    class(rooms_t), intent(inout) :: self
    type(model_t), intent(in) :: model
    !> parameters, time, tables
    real(rk), intent(in) :: state(:)
    !> [time]
    real(rk), intent(in) :: dt
    integer :: i

    do i = 1, size(model%parts)
      call model%parts(i)%reduced%begin_step(self%of_part(i)%room, state, dt)
    end do
  end subroutine begin_step

  !> Begins a history in all parts that remember (forget of sig_reduced).
  subroutine forget(self, model)
    class(rooms_t), intent(inout) :: self
    type(model_t), intent(in) :: model
    integer :: i

    do i = 1, size(model%parts)
      call model%parts(i)%reduced%forget(self%of_part(i)%room)
    end do
  end subroutine forget

  !> Leaves out inelastic strains at integration points. Requires: enter for all parts, before the first answer.
  subroutine leave_out_points(self)
    class(rooms_t), intent(inout) :: self
    integer :: i

    do i = 1, size(self%of_part)
      self%of_part(i)%room%has_points = .false.
    end do
  end subroutine leave_out_points

  !> Gives what the next answer of a history depends on, for all parts (save_memory of sig_reduced).
  subroutine save_memory(self, model, numbers)
    class(rooms_t), intent(in) :: self
    type(model_t), intent(in) :: model
    !> one part after the other
    real(rk), intent(inout) :: numbers(:)
    integer :: first, i

    first = 1
    do i = 1, size(model%parts)
      associate (part => model%parts(i)%reduced)
        call part%save_memory(self%of_part(i)%room, numbers(first:first + part%n_remembered() - 1))
        first = first + part%n_remembered()
      end associate
    end do
  end subroutine save_memory

  !> Goes back to where these numbers were given. is_valid: they are such.
  subroutine restore_memory(self, model, numbers, is_valid)
    class(rooms_t), intent(inout) :: self
    type(model_t), intent(in) :: model
    real(rk), intent(in) :: numbers(:)
    logical, intent(out) :: is_valid
    integer :: first, i
    logical :: is_part

    first = 1
    is_valid = .true.
    do i = 1, size(model%parts)
      associate (part => model%parts(i)%reduced)
        call part%restore_memory(self%of_part(i)%room, numbers(first:first + part%n_remembered() - 1), is_part)
        first = first + part%n_remembered()
      end associate
      is_valid = is_valid .and. is_part
    end do
  end subroutine restore_memory
end module sig_rooms
