! SPDX-License-Identifier: BSD-3-Clause
!> The box of the parameters of a deck: names, middle and corners, and points as text for the messages of the deck.
module sig_deck_box
  use sig_deck_config, only: parameter_config_t
  use sig_kinds, only: rk
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: corners_of, corners_to_try, in_box, names_of, point_text

  !> largest number of parameters for which all corners of the box are tried
  integer, parameter, public :: max_corner_parameters = 10

contains

  pure function names_of(parameters) result(names)
    type(parameter_config_t), intent(in) :: parameters(:)
    type(string_t) :: names(size(parameters))
    integer :: i

    do i = 1, size(parameters)
      names(i)%text = parameters(i)%name
    end do
  end function names_of

  !> Returns the middle of the box, then its corners in some parameters, where all others are at their minimum; shape
  !> (n_parameters, 1 + 2**size(varied)). The first of these parameters changes fastest, from its minimum.
  pure function corners_of(parameters, varied) result(points)
    type(parameter_config_t), intent(in) :: parameters(:)
    !> numbers of the parameters, 1-based
    integer, intent(in) :: varied(:)
    real(rk) :: points(size(parameters), 0:2**size(varied))
    integer :: i, k

    points(:, 0) = parameters%minimum / 2 + parameters%maximum / 2
    do i = 1, 2**size(varied)
      points(:, i) = parameters%minimum
      do k = 1, size(varied)
        if (btest(i - 1, k - 1)) points(varied(k), i) = parameters(varied(k))%maximum
      end do
    end do
  end function corners_of

  !> Returns the middle of the box and all of its corners; with more than 10 parameters the middle, the lowest and the highest
  !> corner. Shape (n_parameters, n).
  pure function corners_to_try(parameters) result(points)
    type(parameter_config_t), intent(in) :: parameters(:)
    real(rk), allocatable :: points(:, :)
    integer :: i

    if (size(parameters) <= max_corner_parameters) then
      points = corners_of(parameters, [(i, i=1, size(parameters))])
    else
      points = reshape([corners_of(parameters, [integer ::]), parameters%maximum], [size(parameters), 3])
    end if
  end function corners_to_try

  !> Maps points from the unit cube into the box.
  pure function in_box(fractions, parameters) result(points)
    !> [-] from 0 to 1, shape (n_parameters, n_points)
    real(rk), intent(in) :: fractions(:, :)
    type(parameter_config_t), intent(in) :: parameters(:)
    real(rk) :: points(size(fractions, 1), size(fractions, 2))
    integer :: i

    do i = 1, size(fractions, 2)
      points(:, i) = parameters%minimum + fractions(:, i) * (parameters%maximum - parameters%minimum)
    end do
  end function in_box

  !> Returns a point as text, `squeeze = 0.15 m, angle = 2.0`. All parameters are there, with their units if they have one.
  pure function point_text(parameters, point) result(text)
    type(parameter_config_t), intent(in) :: parameters(:)
    real(rk), intent(in) :: point(:)
    character(:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(parameters)
      if (i > 1) text = text // ', '
      text = text // parameters(i)%name // ' = ' // to_text(point(i))
      if (len(parameters(i)%unit) > 0) text = text // ' ' // parameters(i)%unit
    end do
  end function point_text
end module sig_deck_box
