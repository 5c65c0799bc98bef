! SPDX-License-Identifier: BSD-3-Clause
!> A model made ready for queries: what does not depend on the point is computed once. Any number of threads may share it.
module sig_online_model
  use sig_kinds, only: rk
  use sig_linear_algebra, only: lu_t
  use sig_model, only: complete_model, model_t, reconstruct_with_displacements, reduced_model_t
  use sig_multiplier_fit, only: multiplier_fit_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: online_model_t, cluster_system_t

  !> One cluster condensed on its multipliers.
  type :: cluster_system_t
    integer :: n_rows = 0
    integer :: n_modes = 0
    !> W = M K_r^-1 M', shape (n_rows, n_rows)
    real(rk), allocatable :: condensed(:, :)
    !> (q, K_r^-1 F) = response theta with q = D - M K_r^-1 F, shape (n_rows + n_modes, n_terms)
    real(rk), allocatable :: response(:, :)
    !> gamma = K_r^-1 F - multiplier_response lambda, shape (n_modes, n_rows)
    real(rk), allocatable :: multiplier_response(:, :)
  end type cluster_system_t

  type :: online_model_t
    !> set by the caller before prepare
    type(model_t) :: model
    !> of each cluster
    type(cluster_system_t), allocatable :: systems(:)
    type(multiplier_fit_t), allocatable :: fits(:)
    !> [-] 1 / length of each side of the box, 0 for a side without length; shape (n_parameters)
    real(rk), allocatable :: box_scale(:)
  contains
    procedure :: prepare
    procedure :: nearest_point
    procedure :: opposite_point
    procedure :: is_inside_box
  end type online_model_t

  !> a point counts as inside when it is beyond a side by less than this part of the side's length (rounded grid points)
  real(rk), parameter :: box_tolerance = 1.0e-9_rk

contains

  !> Condenses each cluster on its multipliers, and prepares the fit of all its multipliers.
  !>
  !> Errors: message is allocated when a reduced stiffness is numerically singular.
  subroutine prepare(self, message)
    class(online_model_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: message
    integer :: i

    call complete_model(self%model)
    if (allocated(self%systems)) deallocate (self%systems, self%fits)
    allocate (self%systems(size(self%model%clusters)), self%fits(size(self%model%clusters)))
    associate (sides => self%model%box(2, :) - self%model%box(1, :))
      self%box_scale = merge(1 / max(sides, tiny(1.0_rk)), 0.0_rk, sides > 0)
    end associate
    do i = 1, size(self%systems)
      call self%fits(i)%prepare(self%model%clusters(i), self%model%reconstruction == reconstruct_with_displacements)
      call condense(self%model%clusters(i), self%systems(i), message)
      if (.not. allocated(message)) cycle
      message = 'cluster ' // to_text(i) // ': ' // message
      return
    end do
  end subroutine prepare

  subroutine condense(cluster, system, message)
    type(reduced_model_t), intent(in) :: cluster
    type(cluster_system_t), intent(out) :: system
    character(:), allocatable, intent(out) :: message
    type(lu_t) :: lu

    call lu%factor(cluster%reduced_stiffness)
    if (lu%is_singular) then
      message = 'the reduced stiffness (' // to_text(cluster%n_modes) // ' modes) is numerically singular: its reciprocal ' &
        // 'condition number is ' // to_text(lu%reciprocal_condition) // '; the equations of the reduced integration domain ' &
        // 'do not determine every mode (a larger pod_tolerance or a zone of interest mends that)'
      return
    end if
    system%n_rows = cluster%n_rows
    system%n_modes = cluster%n_modes
    system%multiplier_response = lu%solve(transpose(cluster%contact_matrix))
    system%condensed = matmul(cluster%contact_matrix, system%multiplier_response)
    allocate (system%response(cluster%n_rows + cluster%n_modes, size(cluster%load, 2)))
    system%response(cluster%n_rows + 1:, :) = lu%solve(cluster%load)
    system%response(:cluster%n_rows, :) = cluster%gap - matmul(cluster%contact_matrix, system%response(cluster%n_rows + 1:, :))
  end subroutine condense

  !> Training point nearest to a point, sides of the box taken as of length 1; the first of several. 0 without training points.
  pure subroutine nearest_point(self, point, i_nearest, distance)
    class(online_model_t), intent(in) :: self
    real(rk), intent(in) :: point(:)
    integer, intent(out) :: i_nearest
    !> [-] huge without training points
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

  !> Training point nearest to a point among those on its other side, seen from its nearest training point: the two enclose it.
  !>
  !> On the other side is an angle of 90 degrees or more at the point; where no training point is there, the nearest but one. The
  !> first of several; 0 without a second training point.
  pure subroutine opposite_point(self, point, i_nearest, i_opposite)
    class(online_model_t), intent(in) :: self
    real(rk), intent(in) :: point(:)
    !> of nearest_point
    integer, intent(in) :: i_nearest
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

  !> The point lies in the box or on its border.
  pure logical function is_inside_box(self, point)
    class(online_model_t), intent(in) :: self
    real(rk), intent(in) :: point(:)
    real(rk) :: margin
    integer :: k

    is_inside_box = .true.
    do k = 1, size(point)
      margin = box_tolerance * (self%model%box(2, k) - self%model%box(1, k))
      is_inside_box = is_inside_box .and. point(k) >= self%model%box(1, k) - margin .and. &
        point(k) <= self%model%box(2, k) + margin
    end do
  end function is_inside_box
end module sig_online_model
