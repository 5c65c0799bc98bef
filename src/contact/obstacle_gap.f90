! SPDX-License-Identifier: BSD-3-Clause
!> The gap between a place and a rigid obstacle along the contact direction, written as an expression.
!>
!> With d the unit direction, c a point of the half space's face or the sphere's center, and s the distance of the place x from the
!> line through c along d: gap = (c - x) . d, for a sphere less sqrt(R^2 - s^2). Beyond its equator, s > R, a sphere continues as
!> the plane through its equator: it acts as a hemispherical punch.
!>
!> The gap of a large sphere is a small difference of large numbers, and rounding would spoil its slopes over the parameters. So the
!> root is written as R - depth, depth = s^2 / (R + sqrt(R^2 - s^2)), and R goes with c . d.
!>
!> At the equator the root has an infinite slope. So that the slope of a gap over each parameter is finite, the last tenth of the
!> height over the plane is a wave. With t = 1 - (s / R)^2 and e = 0.1 this height is
!>   R sqrt(t)                                                     where t > e^2, which is s < 0.995 R
!>   R e (1 - cos(k max(t - t0, 0) / (e^2 - t0))) / (1 - cos k)    elsewhere, t0 = 0.002; 0 where s > 0.999 R
!> With tan(k / 2) = 2 k e^2 / (e^2 - t0) its value and slope over t at t = e^2 are those of the root, e R and R / (2 e); at t = t0
!> both are 0. t0 is not 0 so that a node at s = R is far from both ends of the wave. The height is that of the root or less, by up
!> to 0.053 R, so that nothing interferes that would not without the wave. The function _sphere_depth of expressions
!> (src/terms/expression.c) is R less this height.
module sig_obstacle_gap
  use sig_deck_config, only: contact_config_t, value_config_t
  use sig_kinds, only: rk
  use sig_rounding, only: rounding
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: obstacle_gap

contains

  !> Writes the gap as the sum of two expressions, shape + shift. At most one of them depends on the parameters, so that a plane
  !> that moves, or a sphere that moves along d, is one term and not one per node.
  pure subroutine obstacle_gap(contact, coordinate_names, shape, shift)
    !> entry of the deck's contact section with an obstacle
    type(contact_config_t), intent(in) :: contact
    !> names of the coordinates in expressions, shape (n_dim)
    type(string_t), intent(in) :: coordinate_names(:)
    !> [length] depends on the coordinates, and on the parameters if they move a sphere sideways or change its size
    type(value_config_t), intent(out) :: shape
    !> [length] (point of the obstacle) . d, or (center) . d - R, without coordinates; 0 if shape has taken it over
    type(value_config_t), intent(out) :: shift
    real(rk) :: direction(size(contact%direction))
    integer :: i

    direction = contact%direction / norm2(contact%direction)
    where (abs(direction) < rounding) direction = 0
    shift%text = '0'
    shape%text = '0'
    do i = 1, size(direction)
      if (.not. abs(direction(i)) > 0) cycle
      call add_product(direction(i), contact%obstacle%place(i), shift)
      shape%text = shape%text // ' - ' // factor(direction(i)) // coordinate_names(i)%text
    end do
    shape%uses_coordinates = .true.
    if (contact%obstacle%type == 'sphere') then
      call add_product(-1.0_rk, contact%obstacle%radius, shift)
      call add_depth(contact, direction, coordinate_names, shape)
    end if
    if (shape%uses_parameters .and. shift%uses_parameters) then
      shape%text = shape%text // ' + (' // shift%text // ')'
      shift = value_config_t(text='0')
    end if
    shape%is_constant = .false.
    shape%line = contact%obstacle%line
    shape%column = contact%obstacle%column
    shift%line = contact%obstacle%line
    shift%column = contact%obstacle%column
  end subroutine obstacle_gap

  !> sum = sum + number * value: the text, the constant, is_constant and uses_parameters.
  pure subroutine add_product(number, value, sum)
    real(rk), intent(in) :: number
    type(value_config_t), intent(in) :: value
    type(value_config_t), intent(inout) :: sum

    sum%text = sum%text // ' + ' // factor(number) // '(' // value%text // ')'
    sum%constant = sum%constant + number * value%constant
    sum%is_constant = sum%is_constant .and. value%is_constant
    sum%uses_parameters = sum%uses_parameters .or. value%uses_parameters
  end subroutine add_product

  !> shape = shape + depth below the top of the sphere at s, the length of the cross product of q = x - c and d. Sets
  !> shape%uses_parameters: whether R does, or a component of c that is not along d.
  pure subroutine add_depth(contact, direction, coordinate_names, shape)
    type(contact_config_t), intent(in) :: contact
    !> [-] unit vector d
    real(rk), intent(in) :: direction(:)
    type(string_t), intent(in) :: coordinate_names(:)
    type(value_config_t), intent(inout) :: shape
    character(:), allocatable :: product
    integer :: i, j

    product = ''
    do i = 2, 3
      do j = 1, i - 1
        product = product // '0'
        if (i <= size(direction)) product = product // part(i, j) // part(j, i)
        product = product // ', '
      end do
    end do
    shape%uses_parameters = contact%obstacle%radius%uses_parameters .or. &
      any(contact%obstacle%place%uses_parameters .and. abs(direction) < 1)
    shape%text = shape%text // ' + _sphere_depth(' // product // contact%obstacle%radius%text // ')'

  contains

    !> q_i d_j - q_j d_i is part(i, j) and part(j, i).
    pure function part(i, j) result(text)
      integer, intent(in) :: i, j
      character(:), allocatable :: text

      text = ''
      if (abs(direction(j)) > 0) text = ' + ' // factor(sign(direction(j), direction(j) * (i - j))) // &
        '(' // coordinate_names(i)%text // ' - (' // contact%obstacle%place(i)%text // '))'
    end function part
  end subroutine add_depth

  !> Returns a factor as a text, such as `(0.6)*`.
  pure function factor(number) result(text)
    real(rk), intent(in) :: number
    character(:), allocatable :: text

    text = '(' // to_text(number) // ')*'
  end function factor
end module sig_obstacle_gap
