! SPDX-License-Identifier: BSD-3-Clause
!> A model prepared for queries: everything that does not depend on the point is computed once. Any number of threads may share it.
module sig_online_model
  use sig_kinds, only: rk
  use sig_model, only: complete_model, model_t
  use sig_rounding, only: rounding_of_data
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: online_model_t

  type :: online_model_t
    !> the model; the caller sets it before prepare
    type(model_t) :: model
    !> [-] 1 / length of each side of the box, 0 for a side without length; shape (n_parameters)
    real(rk), allocatable :: box_scale(:)
  contains
    procedure :: prepare
    procedure :: nearest_point
    procedure :: opposite_point
    procedure :: is_inside_box
    procedure :: lengths_at
    procedure :: n_remembered
  end type online_model_t

contains

  !> Allocates what the model lacks (complete_model), sets box_scale, and prepares every part for queries, the fallback, too.
  !>
  !> Errors: message is allocated when a part cannot answer; the parts after it are not prepared then. For a cluster it begins with
  !> the number of the cluster.
  subroutine prepare(self, message)
    class(online_model_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: message
    integer :: i

    call complete_model(self%model)
    associate (sides => self%model%box(2, :) - self%model%box(1, :))
      self%box_scale = merge(1 / max(sides, tiny(1.0_rk)), 0.0_rk, sides > 0)
    end associate
    do i = 1, size(self%model%parts)
      call self%model%parts(i)%reduced%prepare(message)
      if (.not. allocated(message)) cycle
      if (i <= self%model%n_clusters()) message = 'cluster ' // to_text(i) // ': ' // message
      return
    end do
  end subroutine prepare

  !> Finds the training point with the least Euclidean distance to a point, with each side of the box scaled to 1; of several, the
  !> first. Parameters whose side of the box has no length do not count. If a parameter of the point is NaN, the result is the last
  !> training point, at a distance NaN. Requires: prepare.
  pure subroutine nearest_point(self, point, i_nearest, distance)
    class(online_model_t), intent(in) :: self
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> number of the training point, 1-based; 0 without training points, or if all squared distances overflow
    integer, intent(out) :: i_nearest
    !> [-] distance to it; huge if i_nearest is 0
    real(rk), intent(out) :: distance
    real(rk) :: square
    integer :: i, k

    i_nearest = 0
    distance = huge(distance)
    do i = 1, size(self%model%training_points, 2)
      square = 0
      do k = 1, size(point)
        square = square + ((point(k) - self%model%training_points(k, i)) * self%box_scale(k))**2
      end do
      if (square >= distance) cycle
      distance = square
      i_nearest = i
    end do
    if (i_nearest > 0) distance = sqrt(distance)
  end subroutine nearest_point

  !> Finds the nearest of the training points that lie on the other side of a point than its nearest training point. On the other
  !> side means: at the point, the directions to both training points make an angle of 90 degrees or more. If no training point is
  !> there, or if the point is a training point itself, the result is the second nearest training point. Of several at the same
  !> distance, the first counts. Distances and angles are those of the scaled box (nearest_point). Requires: prepare.
  pure subroutine opposite_point(self, point, i_nearest, i_opposite)
    class(online_model_t), intent(in) :: self
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> result of nearest_point at this point
    integer, intent(in) :: i_nearest
    !> number of the training point, 1-based; 0 if there are fewer than two, if i_nearest is 0, or if all squared distances overflow
    integer, intent(out) :: i_opposite
    real(rk) :: along, distance, distance_opposite, square
    integer :: i, i_second, k

    i_opposite = 0
    if (i_nearest == 0) return
    i_second = 0
    distance = huge(distance)
    distance_opposite = huge(distance_opposite)
    do i = 1, size(self%model%training_points, 2)
      if (i == i_nearest) cycle
      square = 0
      along = 0
      do k = 1, size(point)
        associate (away => (self%model%training_points(k, i) - point(k)) * self%box_scale(k), &
          nearest => (self%model%training_points(k, i_nearest) - point(k)) * self%box_scale(k))
          square = square + away**2
          along = along + away * nearest
        end associate
      end do
      if (square < distance) then
        distance = square
        i_second = i
      end if
      if (along > 0 .or. square >= distance_opposite) cycle
      distance_opposite = square
      i_opposite = i
    end do
    if (i_opposite == 0) i_opposite = i_second
  end subroutine opposite_point

  !> Whether the point lies in the trained box, on its border, or outside by at most 1e-9 of the length of a side, as points of
  !> grids are rounded; false if a parameter is NaN.
  pure logical function is_inside_box(self, point)
    class(online_model_t), intent(in) :: self
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    real(rk) :: margin
    integer :: k

    is_inside_box = .true.
    do k = 1, size(point)
      margin = rounding_of_data * (self%model%box(2, k) - self%model%box(1, k))
      is_inside_box = is_inside_box .and. point(k) >= self%model%box(1, k) - margin .and. &
        point(k) <= self%model%box(2, k) + margin
    end do
  end function is_inside_box

  !> Returns for each parameter a length in its unit; the steps of finite differences are fractions of it. It is the side of the
  !> box, or the absolute value of the parameter if the side is zero, or 1 if both are zero.
  pure function lengths_at(self, point) result(lengths)
    class(online_model_t), intent(in) :: self
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    real(rk) :: lengths(size(point))

    lengths = self%model%box(2, :) - self%model%box(1, :)
    where (.not. lengths > 0) lengths = abs(point)
    where (.not. lengths > 0) lengths = 1
  end function lengths_at

  !> Returns how many numbers say what the next time of a history depends on (save_memory of sig_query); 0 without a history.
  pure integer function n_remembered(self) result(n)
    class(online_model_t), intent(in) :: self
    integer :: i

    n = 0
    if (.not. self%model%history%is_there()) return
    n = 1 + self%model%n_given()
    do i = 1, size(self%model%parts)
      n = n + self%model%parts(i)%reduced%n_remembered()
    end do
  end function n_remembered
end module sig_online_model
