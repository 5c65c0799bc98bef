! SPDX-License-Identifier: BSD-3-Clause
!> The cells between the points of a regular grid in a box of any dimension: the corners of a cell, and the cell of a point.
module sig_grid_cells
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: grid_cells_t

  !> [-] share of a cell's width: a point that is above a border by at most this counts as on the border
  real(rk), parameter :: border_tolerance = 1.0e-8_rk

  !> A grid of n_values points per parameter, ends included, the first parameter slowest. A parameter of one value has one
  !> layer of cells, as wide as the box. Cells are numbered as points are: 1-based, the first parameter slowest.
  type :: grid_cells_t
    !> points per parameter, >= 1, shape (n_parameters)
    integer, allocatable :: n_values(:)
    !> [unit of each parameter] minimum < maximum, shape (2, n_parameters)
    real(rk), allocatable :: box(:, :)
  contains
    procedure :: n_cells
    procedure :: corners
    procedure :: find
    procedure :: squared_distance
    procedure, private :: n_layers
  end type grid_cells_t

contains

  !> Returns the number of cells along each parameter, at least 1.
  pure function n_layers(self) result(counts)
    class(grid_cells_t), intent(in) :: self
    integer :: counts(size(self%n_values))

    counts = max(1, self%n_values - 1)
  end function n_layers

  !> Returns the number of cells of the grid.
  pure integer function n_cells(self)
    class(grid_cells_t), intent(in) :: self

    n_cells = product(self%n_layers())
  end function n_cells

  !> Returns the numbers of the grid points at the corners of a cell, 1-based, ascending. In the order of the points the last
  !> parameter is the fastest. There are 2**n_parameters corners; each parameter of one value halves this number.
  pure function corners(self, i_cell) result(points)
    class(grid_cells_t), intent(in) :: self
    !> number of the cell, 1-based
    integer, intent(in) :: i_cell
    integer, allocatable :: points(:)
    integer :: layers_0(size(self%n_values)), i_parameter, step

    layers_0 = digits_of(i_cell - 1, self%n_layers())
    points = [1]
    step = 1
    do i_parameter = size(self%n_values), 1, -1
      points = points + layers_0(i_parameter) * step
      if (self%n_values(i_parameter) > 1) points = [points, points + step]
      step = step * self%n_values(i_parameter)
    end do
  end function corners

  !> Returns the number of the cell that a point lies in, 1-based. On a border between cells, or above it by up to 1e-8 of a cell's
  !> width, it is the cell with the lower number; for a point outside of the box it is the cell that is nearest to the point.
  pure integer function find(self, point) result(i_cell)
    class(grid_cells_t), intent(in) :: self
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    integer :: counts(size(self%n_values)), i_parameter, layer_0
    real(rk) :: position

    counts = self%n_layers()
    i_cell = 1
    do i_parameter = 1, size(counts)
      associate (minimum => self%box(1, i_parameter), maximum => self%box(2, i_parameter), n => counts(i_parameter))
        position = min(max((point(i_parameter) - minimum) / (maximum - minimum), 0.0_rk), 1.0_rk) * n
        layer_0 = min(n - 1, max(0, ceiling(position - border_tolerance) - 1))
        i_cell = 1 + (i_cell - 1) * n + layer_0
      end associate
    end do
  end function find

  !> Returns the squared distance [-] from a point to the nearest point of a cell, with each side of the box scaled to 1; 0 inside
  !> the cell.
  pure real(rk) function squared_distance(self, i_cell, point) result(distance)
    class(grid_cells_t), intent(in) :: self
    !> number of the cell, 1-based
    integer, intent(in) :: i_cell
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    integer :: i_parameter, layers_0(size(self%n_values))
    real(rk) :: position

    layers_0 = digits_of(i_cell - 1, self%n_layers())
    distance = 0
    do i_parameter = 1, size(layers_0)
      associate (minimum => self%box(1, i_parameter), maximum => self%box(2, i_parameter), &
        n => max(1, self%n_values(i_parameter) - 1))
        position = (point(i_parameter) - minimum) / (maximum - minimum) * n - layers_0(i_parameter)
        distance = distance + (max(0.0_rk, -position, position - 1) / n)**2
      end associate
    end do
  end function squared_distance

  !> Returns the digits of a number >= 0, each to a base of its own: digit i is between 0 and bases(i) - 1. The last digit is the
  !> least significant one.
  pure function digits_of(number, bases) result(digits)
    integer, intent(in) :: number
    integer, intent(in) :: bases(:)
    integer :: digits(size(bases))
    integer :: i, rest

    rest = number
    do i = size(bases), 1, -1
      digits(i) = modulo(rest, bases(i))
      rest = rest / bases(i)
    end do
  end function digits_of
end module sig_grid_cells
