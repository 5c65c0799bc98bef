! SPDX-License-Identifier: BSD-3-Clause
!> Interpolation by polynomials of several variables in a box, up to a total degree.
!>
!> The nodes are discrete Leja points. They are the pivots of a Gauss elimination of a matrix with one row per candidate point and
!> one column per polynomial; the polynomials are in the order of their degree. The nodes of a degree are therefore the first nodes
!> of every higher degree, and responses that were computed there are used again.
module sig_polynomial_nodes
  use sig_kinds, only: rk
  use sig_linear_algebra, only: invert
  implicit none(type, external)
  private
  public :: polynomial_nodes_t, number_of_polynomials

  !> The interpolation nodes of a box.
  type :: polynomial_nodes_t
    !> ends of the box, shape (n_variables)
    real(rk), allocatable :: lower(:)
    real(rk), allocatable :: upper(:)
    !> [-] nodes, scaled to -1 to 1 in each variable, shape (n_variables, n_nodes)
    real(rk), allocatable :: nodes(:, :)
    !> degree of each polynomial in each variable, shape (n_variables, n_nodes)
    integer, allocatable, private :: degrees(:, :)
    !> inverse of the matrix of the values of the polynomials (columns) at the nodes (rows), shape (n_nodes, n_nodes)
    real(rk), allocatable, private :: inverse(:, :)
  contains
    procedure :: create
    procedure :: prepare
    procedure :: n_nodes
    procedure :: node
    procedure :: on_line
    procedure :: weights
    procedure :: weight_changes
  end type polynomial_nodes_t

  !> number of candidate points for one variable, and for several
  integer, parameter :: n_on_line = 401
  integer, parameter :: n_in_box = 4000
  integer, parameter :: primes(10) = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29]

  !> largest number of variables
  integer, parameter, public :: most_variables = size(primes)

contains

  !> Chooses the nodes for all polynomials up to a total degree, number_of_polynomials(n_variables, degree) nodes, and prepares the
  !> weights. Requires: at most most_variables variables, and not more nodes than candidate_points returns.
  subroutine create(self, lower, upper, degree)
    class(polynomial_nodes_t), intent(inout) :: self
    !> ends of the box, lower < upper, in the units of the variables; shape (n_variables)
    real(rk), intent(in) :: lower(:)
    real(rk), intent(in) :: upper(:)
    !> largest total degree, >= 0
    integer, intent(in) :: degree
    real(rk), allocatable :: candidates(:, :)
    integer, allocatable :: chosen(:)

    self%lower = lower
    self%upper = upper
    self%degrees = degrees_up_to(size(lower), number_of_polynomials(size(lower), degree))
    candidates = candidate_points(size(lower))
    call choose_pivots(polynomials(self%degrees, candidates), chosen)
    self%nodes = candidates(:, chosen)
    call self%prepare()
  end subroutine create

  !> Computes what `weights` needs from the component `nodes`, for example after the nodes were read from a file. If the nodes do
  !> not determine the polynomials, as where two nodes are the same, all weights are zero afterwards.
  subroutine prepare(self)
    class(polynomial_nodes_t), intent(inout) :: self
    logical :: is_singular

    self%degrees = degrees_up_to(size(self%nodes, 1), size(self%nodes, 2))
    if (allocated(self%inverse)) deallocate (self%inverse)
    allocate (self%inverse(size(self%nodes, 2), size(self%nodes, 2)))
    call invert(polynomials(self%degrees, self%nodes), self%inverse, is_singular)
  end subroutine prepare

  !> Returns the number of nodes.
  pure integer function n_nodes(self)
    class(polynomial_nodes_t), intent(in) :: self

    n_nodes = size(self%nodes, 2)
  end function n_nodes

  !> Returns the coordinates of node i in the box, in the units of the variables.
  pure function node(self, i) result(place)
    class(polynomial_nodes_t), intent(in) :: self
    !> 1 to n_nodes
    integer, intent(in) :: i
    !> shape (n_variables)
    real(rk) :: place(size(self%nodes, 1))

    place = ((1 - self%nodes(:, i)) * self%lower + (1 + self%nodes(:, i)) * self%upper) / 2
  end function node

  !> Returns all nodes in the units of the variable. Requires: one variable.
  pure function on_line(self) result(places)
    class(polynomial_nodes_t), intent(in) :: self
    !> shape (n_nodes)
    real(rk) :: places(size(self%nodes, 2))

    places = ((1 - self%nodes(1, :)) * self%lower(1) + (1 + self%nodes(1, :)) * self%upper(1)) / 2
  end function on_line

  !> Computes the weights of the nodes at a place, which may lie outside of the box: the interpolated f(place) is the sum of weights
  !> times f(nodes).
  pure subroutine weights(self, place, values)
    class(polynomial_nodes_t), intent(in) :: self
    !> in the units of the variables, shape (n_variables)
    real(rk), intent(in) :: place(:)
    !> [-] shape (n_nodes)
    real(rk), contiguous, intent(inout) :: values(:)
    real(rk) :: scaled(size(place))
    integer :: i

    scaled = (2 * place - self%lower - self%upper) / (self%upper - self%lower)
    values = 0
    do i = 1, size(values)
      values = values + polynomial(self%degrees(:, i), scaled) * self%inverse(i, :)
    end do
  end subroutine weights

  !> Computes the derivatives of the weights at a place in the direction `move`, which need not have length 1: d weights(place + t
  !> move) / dt at t = 0.
  pure subroutine weight_changes(self, place, move, values)
    class(polynomial_nodes_t), intent(in) :: self
    !> in the units of the variables, shape (n_variables)
    real(rk), intent(in) :: place(:)
    !> in the units of the variables, shape (n_variables)
    real(rk), intent(in) :: move(:)
    !> [-] shape (n_nodes)
    real(rk), contiguous, intent(inout) :: values(:)
    real(rk) :: scaled(size(place)), scaled_move(size(place))
    integer :: i

    values = 0
    if (.not. any(abs(move) > 0)) return
    scaled = (2 * place - self%lower - self%upper) / (self%upper - self%lower)
    scaled_move = 2 * move / (self%upper - self%lower)
    do i = 1, size(values)
      values = values + polynomial_change(self%degrees(:, i), scaled, scaled_move) * self%inverse(i, :)
    end do
  end subroutine weight_changes

  !> Returns the number of polynomials of n variables up to a total degree, the binomial coefficient (degree + n) over n.
  pure integer function number_of_polynomials(n_variables, degree) result(number)
    integer, intent(in) :: n_variables
    integer, intent(in) :: degree
    integer :: i

    number = 1
    do i = 1, n_variables
      number = number * (degree + i) / i
    end do
  end function number_of_polynomials

  !> Returns the degree in each variable of each of the first n polynomials. They are in the order of their total degree; of the
  !> same total degree first those with the higher degree in the earlier variables.
  pure function degrees_up_to(n_variables, n) result(degrees)
    integer, intent(in) :: n_variables
    integer, intent(in) :: n
    integer :: degrees(n_variables, n)
    integer :: candidate(n_variables), i, i_variable, total

    if (n_variables == 0) return
    i = 0
    total = 0
    do while (i < n)
      ! all polynomials of this total degree
      candidate = 0
      candidate(1) = total
      do
        i = i + 1
        degrees(:, i) = candidate
        if (i == n .or. candidate(n_variables) == total) exit
        i_variable = findloc(candidate(:n_variables - 1) > 0, .true., dim=1, back=.true.)
        candidate(i_variable) = candidate(i_variable) - 1
        candidate(i_variable + 1) = total - sum(candidate(:i_variable))
        candidate(i_variable + 2:) = 0
      end do
      total = total + 1
    end do
  end function degrees_up_to

  !> Returns the candidates for nodes: 401 for one variable, 4000 for several, one without coordinates for none. They are dense near
  !> the ends of each variable, where good interpolations have many nodes.
  pure function candidate_points(n_variables) result(points)
    integer, intent(in) :: n_variables
    !> [-] -1 to 1, shape (n_variables, n_candidates)
    real(rk), allocatable :: points(:, :)
    real(rk), parameter :: pi = acos(-1.0_rk)
    integer :: i, k

    if (n_variables == 0) then
      allocate (points(0, 1))
    else if (n_variables == 1) then
      points = reshape([(cos(pi * real(i, rk) / (n_on_line - 1)), i=0, n_on_line - 1)], [1, n_on_line])
    else
      allocate (points(n_variables, n_in_box))
      do i = 1, n_in_box
        do k = 1, n_variables
          points(k, i) = cos(pi * radical_inverse(i, primes(k)))
        end do
      end do
    end if
  end function candidate_points

  !> Returns entry `number` of Halton's sequence, 0 to 1: the digits of the number in this base, in reverse order behind the point.
  pure real(rk) function radical_inverse(number, base) result(value)
    integer, intent(in) :: number
    integer, intent(in) :: base
    real(rk) :: place
    integer :: left

    value = 0
    place = 1
    left = number
    do while (left > 0)
      place = place / base
      value = value + place * modulo(left, base)
      left = left / base
    end do
  end function radical_inverse

  !> Returns the values of all polynomials at all points, shape (n_points, n_polynomials). `degrees` are those of degrees_up_to, and
  !> `points` have coordinates that are -1 to 1 in the box, shape (n_variables, n_points).
  pure function polynomials(degrees, points) result(values)
    integer, intent(in) :: degrees(:, :)
    real(rk), intent(in) :: points(:, :)
    real(rk), allocatable :: values(:, :)
    integer :: i, k

    allocate (values(size(points, 2), size(degrees, 2)))
    do k = 1, size(degrees, 2)
      do i = 1, size(points, 2)
        values(i, k) = polynomial(degrees(:, k), points(:, i))
      end do
    end do
  end function polynomials

  !> Returns the value of one polynomial at a point: the product of the Chebyshev polynomials of the variables, with one degree and
  !> one coordinate for each variable. Coordinates may lie outside of -1 to 1.
  pure real(rk) function polynomial(degrees, point)
    integer, intent(in) :: degrees(:)
    real(rk), intent(in) :: point(:)
    integer :: i

    polynomial = 1
    do i = 1, size(degrees)
      polynomial = polynomial * chebyshev(degrees(i), point(i))
    end do
  end function polynomial

  !> Returns the derivative of one polynomial (see polynomial) at a point in the direction `move`, which need not have length 1.
  pure real(rk) function polynomial_change(degrees, point, move) result(change)
    integer, intent(in) :: degrees(:)
    real(rk), intent(in) :: point(:)
    real(rk), intent(in) :: move(:)
    real(rk) :: factor
    integer :: i, k

    change = 0
    do i = 1, size(degrees)
      factor = chebyshev_slope(degrees(i), point(i)) * move(i)
      do k = 1, size(degrees)
        if (k /= i) factor = factor * chebyshev(degrees(k), point(k))
      end do
      change = change + factor
    end do
  end function polynomial_change

  !> Returns the Chebyshev polynomial T_n(x) by T_k+1 = 2 x T_k - T_k-1.
  pure real(rk) function chebyshev(degree, x) result(value)
    integer, intent(in) :: degree
    real(rk), intent(in) :: x
    real(rk) :: before, next
    integer :: k

    value = 1
    before = x
    do k = 1, degree
      next = 2 * x * value - before
      before = value
      value = next
    end do
  end function chebyshev

  !> Returns T_n'(x) = n U_n-1(x) by U_k+1 = 2 x U_k - U_k-1.
  pure real(rk) function chebyshev_slope(degree, x) result(slope)
    integer, intent(in) :: degree
    real(rk), intent(in) :: x
    real(rk) :: before, next
    integer :: k

    slope = 0
    before = -1
    do k = 1, degree
      next = 2 * x * slope - before
      before = slope
      slope = next
    end do
    slope = degree * slope
  end function chebyshev_slope

  !> Chooses one candidate per column by Gauss elimination: each time the candidate with the largest absolute value in the column,
  !> from which the columns before are eliminated; of nearly equal ones (1e-8) the first.
  pure subroutine choose_pivots(values, chosen)
    !> shape (n_candidates, n)
    real(rk), intent(in) :: values(:, :)
    !> numbers of the candidates, 1-based, shape (n)
    integer, allocatable, intent(out) :: chosen(:)
    real(rk) :: left(size(values, 1), size(values, 2))
    real(rk) :: largest
    integer :: i, k

    left = values
    allocate (chosen(size(values, 2)))
    do k = 1, size(values, 2)
      largest = maxval(abs(left(:, k)))
      chosen(k) = findloc(abs(left(:, k)) >= (1 - 1.0e-8_rk) * largest, .true., dim=1)
      do i = k + 1, size(values, 2)
        left(:, i) = left(:, i) - left(:, k) * (left(chosen(k), i) / left(chosen(k), k))
      end do
    end do
  end subroutine choose_pivots
end module sig_polynomial_nodes
