! SPDX-License-Identifier: BSD-3-Clause
!> The elastic constants of each body as functions of the parameters. The stiffness of a body is proportional to the Young's modulus
!> of its first material. Its responses are interpolated over the other constants that vary: Poisson's ratios, and the ratios of the
!> other moduli to the first one. A variable of the interpolation is such a constant or its logarithm (to_variable).
module sig_body_constants
  use sig_bodies, only: regions_of_body
  use sig_deck_box, only: corners_of, in_box
  use sig_deck_config, only: deck_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_errors, only: error_t
  use sig_interpolated_constants, only: to_constant, to_variable
  use sig_kinds, only: rk
  use sig_latin_hypercube, only: latin_hypercube_points
  use sig_materials, only: check_materials
  use sig_polynomial_nodes, only: number_of_polynomials
  use sig_problem, only: problem_t
  use sig_rounding, only: rounding
  use sig_term_values, only: evaluate_points
  use sig_text, only: join
  implicit none(type, external)
  private
  public :: body_constants_t, joined_body_t, check_box, find_body_constants, usual_nodes_of

  !> The elastic constants of one body. Materials are numbered as in the deck, 1-based.
  type :: body_constants_t
    !> names of its regions, for messages
    character(:), allocatable :: name
    !> its materials, ascending; the stiffness is proportional to the modulus of the first one
    integer, allocatable :: materials(:)
    !> of each of its materials at the middle of the box of the parameters: [force/length**2] moduli, [-] Poisson's ratios
    real(rk), allocatable :: moduli(:)
    real(rk), allocatable :: ratios(:)
    !> index of the first modulus among the problem's terms
    integer :: modulus_term = 0
    !> the constants that vary, as the problem's terms: numerators(i) over denominators(i), or numerators(i) alone if the other is 0
    integer, allocatable :: numerators(:)
    integer, allocatable :: denominators(:)
    !> the variables are the logarithms of to_variable
    logical :: is_logarithmic = .false.
    !> ranges of the variables in the box of the parameters, a little widened; shape (n_variables)
    real(rk), allocatable :: lower(:)
    real(rk), allocatable :: upper(:)
  contains
    procedure :: degree
  end type body_constants_t

  !> All bodies, each with its own materials: a material that two bodies have is there twice, so that one body can change alone.
  type :: joined_body_t
    type(elastic_body_t) :: body
    type(body_constants_t), allocatable :: constants(:)
    !> present constants of each body's materials, one body after the other: [force/length**2] moduli, [-] Poisson's ratios
    real(rk), allocatable :: moduli(:)
    real(rk), allocatable :: ratios(:)
    !> materials of body i are starts(i) + 1 ... starts(i + 1)
    integer, allocatable :: starts(:)
  contains
    procedure :: create
    procedure :: set
  end type joined_body_t

  !> points inside the box at which the constants are computed, beside its middle and its corners
  integer, parameter :: n_samples = 2000
  !> number of parameters above which the corners are left out
  integer, parameter :: most_corners = 12
  real(rk), parameter :: margin = 0.01_rk
  !> [-] with this rate of convergence an error of 1e-6 takes about twenty nodes
  real(rk), parameter :: slowest = 2.0_rk
  !> polynomial degree for estimates of memory
  integer, parameter :: usual_degree = 7

contains

  !> Finds for each body which Poisson's ratios, and which ratios of moduli to its first modulus, vary over points_of_box, whether
  !> the variables of the interpolation are these constants or logarithms, and the widened ranges of the variables. Errors: at one
  !> of these points a constant is not finite or out of its range. Requires: the stiffness depends on the parameters. Local.
  subroutine find_body_constants(problem, constants, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_bodies); not allocated after an error
    type(body_constants_t), allocatable, intent(out) :: constants(:)
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: points(:, :), theta(:, :)
    integer :: i, i_bad_point, i_bad_source

    call check_box(problem, error)
    if (allocated(error)) return
    points = points_of_box(problem%deck)
    call evaluate_points(problem%material_terms, points, theta, i_bad_point, i_bad_source)
    allocate (constants(problem%motions%n_bodies))
    do i = 1, size(constants)
      constants(i)%name = join(regions_of_body(problem%mesh, problem%motions%body_of_node, i), ', ')
      call find_constants(problem, i, theta, constants(i))
    end do
  end subroutine find_body_constants

  !> Checks the elastic constants of all materials at points_of_box: in the middle, at the corners (with up to 12 parameters) and at
  !> 2000 sample points of the box. Does nothing if the stiffness does not depend on the parameters. Errors: as find_body_constants.
  subroutine check_box(problem, error)
    type(problem_t), intent(in) :: problem
    type(error_t), allocatable, intent(out) :: error

    if (problem%has_fixed_stiffness) return
    call check_materials(problem%deck, problem%material_terms, points_of_box(problem%deck), error)
  end subroutine check_box

  !> Returns the degree of the interpolating polynomials of a body in a round of refinement: 3 in round 0 with one variable, 2 with
  !> none or several, and one more in each further round. With several variables the first degree is lower, because each degree
  !> takes many nodes.
  pure integer function degree(self, i_round)
    class(body_constants_t), intent(in) :: self
    !> from 0
    integer, intent(in) :: i_round

    degree = merge(3, 2, size(self%numerators) == 1) + i_round
  end function degree

  !> Returns the mean number of interpolation nodes that a body is likely to need (polynomials of degree 7), for estimates of
  !> memory.
  pure real(rk) function usual_nodes_of(constants) result(n_nodes)
    type(body_constants_t), intent(in) :: constants(:)
    integer :: i

    n_nodes = sum([(real(number_of_polynomials(size(constants(i)%numerators), usual_degree), rk), i=1, size(constants))]) / &
      size(constants)
  end function usual_nodes_of

  !> Returns points of the box of the parameters, shape (size(deck%state_parameters), n_points): first its middle, then its corners
  !> (none with more than 12 parameters) and n_samples points inside, the same in each call. The time and its tables are 0 there,
  !> because constants of materials do not depend on them.
  function points_of_box(deck) result(states)
    type(deck_config_t), intent(in) :: deck
    real(rk), allocatable :: states(:, :)
    real(rk), allocatable :: corners(:, :), points(:, :)
    integer :: i, n

    n = size(deck%parameters)
    corners = corners_of(deck%parameters, [(i, i=1, merge(n, 0, n <= most_corners))])
    if (n > most_corners) corners = corners(:, :1)
    points = in_box(latin_hypercube_points(n, n_samples, 1), deck%parameters)
    allocate (states(size(deck%state_parameters), size(corners, 2) + n_samples), source=0.0_rk)
    states(:n, :size(corners, 2)) = corners
    states(:n, size(corners, 2) + 1:) = points
  end function points_of_box

  subroutine find_constants(problem, i_body, theta, constants)
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: i_body
    !> values of the terms of create_material_terms at points_of_box, shape (n_terms, n_points)
    real(rk), intent(in) :: theta(:, :)
    type(body_constants_t), intent(inout) :: constants
    integer :: i, first

    constants%materials = materials_of_body(problem, i_body)
    constants%moduli = theta(2 * constants%materials, 1)
    constants%ratios = theta(2 * constants%materials + 1, 1)
    allocate (constants%numerators(0), constants%denominators(0), constants%lower(0), constants%upper(0))
    first = constants%materials(1)
    constants%modulus_term = term_of(problem, 2 * first)
    do i = 1, size(constants%materials)
      associate (material => constants%materials(i))
        if (i > 1) call add_variable(problem, 2 * material, 2 * first, theta(2 * material, :) / theta(2 * first, :), constants)
        call add_variable(problem, 2 * material + 1, 0, theta(2 * material + 1, :), constants)
      end associate
    end do
    call choose_variables(constants)
  end subroutine find_constants

  !> Chooses whether the variables are the constants themselves or the logarithms of to_variable, and replaces the ranges of the
  !> constants by those of the variables, widened by 1 % of their width at both ends. A single constant is taken as it is if its
  !> rate_of is at least `slowest`, because its interpolation then has an error bound. If it is less, or with several constants,
  !> logarithms are taken.
  pure subroutine choose_variables(constants)
    !> in: lower and upper are the ranges of the constants that vary; there may be none
    type(body_constants_t), intent(inout) :: constants
    real(rk) :: spread_of(size(constants%numerators))

    associate (is_ratio => constants%denominators > 0)
      constants%is_logarithmic = size(is_ratio) > 1
      if (size(is_ratio) == 1) constants%is_logarithmic = rate_of(constants%lower(1), constants%upper(1), is_ratio(1)) < slowest
      constants%lower = to_variable(constants%lower, is_ratio, constants%is_logarithmic)
      constants%upper = to_variable(constants%upper, is_ratio, constants%is_logarithmic)
    end associate
    spread_of = constants%upper - constants%lower
    constants%lower = constants%lower - margin * spread_of
    constants%upper = constants%upper + margin * spread_of
  end subroutine choose_variables

  !> Returns the factor [-] by which each further node makes the error of polynomials in a constant smaller: the sum of the half
  !> axes of an ellipse, over half of the range of the constant (Bernstein). The ellipse has its foci at the ends of the range and
  !> passes through a constant that makes the stiffness singular: a ratio of moduli of 0, or a Poisson's ratio of 1/2.
  pure real(rk) function rate_of(lower, upper, is_ratio_of_moduli) result(rate)
    !> [-] range of the constant
    real(rk), intent(in) :: lower
    real(rk), intent(in) :: upper
    !> the constant is a ratio of two moduli, otherwise a Poisson's ratio
    logical, intent(in) :: is_ratio_of_moduli
    real(rk) :: distance

    if (is_ratio_of_moduli) then
      distance = (upper + lower) / (upper - lower)
    else
      distance = (1 - upper - lower) / (upper - lower)
    end if
    rate = distance + sqrt(max(0.0_rk, distance**2 - 1))
  end function rate_of

  !> Adds an elastic constant and its range to those that vary, unless its values are the same at all points, up to rounding.
  subroutine add_variable(problem, numerator, denominator, values, constants)
    type(problem_t), intent(in) :: problem
    !> the constant is numerator / denominator, terms of create_material_terms; denominator 0: the numerator alone
    integer, intent(in) :: numerator
    integer, intent(in) :: denominator
    !> of the constant at points_of_box, shape (n_points)
    real(rk), intent(in) :: values(:)
    type(body_constants_t), intent(inout) :: constants
    real(rk) :: spread_of

    spread_of = maxval(values) - minval(values)
    if (spread_of <= rounding * maxval(abs(values))) return
    constants%numerators = [constants%numerators, term_of(problem, numerator)]
    constants%denominators = [constants%denominators, term_of(problem, denominator)]
    constants%lower = [constants%lower, minval(values)]
    constants%upper = [constants%upper, maxval(values)]
  end subroutine add_variable

  !> Returns the index of the problem's term that equals a term of create_material_terms; 0 for 0.
  pure integer function term_of(problem, material_term)
    type(problem_t), intent(in) :: problem
    !> 2 or more, because term 1 is no elastic constant; or 0
    integer, intent(in) :: material_term

    term_of = 0
    if (material_term > 0) term_of = problem%constant_terms(material_term - 1)
  end function term_of

  !> Returns the numbers in the deck (1-based) of the materials of a body's cells, ascending.
  function materials_of_body(problem, i_body) result(materials)
    type(problem_t), intent(in) :: problem
    !> 1-based
    integer, intent(in) :: i_body
    integer, allocatable :: materials(:)
    logical :: is_there(size(problem%deck%materials))
    integer :: i

    is_there = .false.
    do i = 1, size(problem%body%material_of_cell)
      if (body_of_cell(problem, i) == i_body .and. problem%body%material_of_cell(i) > 0) &
        is_there(problem%body%material_of_cell(i)) = .true.
    end do
    materials = pack([(i, i=1, size(is_there))], is_there)
  end function materials_of_body

  pure integer function body_of_cell(problem, i_cell)
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: i_cell

    body_of_cell = problem%motions%body_of_node(problem%mesh%cell_nodes(problem%mesh%cell_offsets(i_cell) + 1))
  end function body_of_cell

  !> Fills all components of self with the constants in the middle of the box. In self%body each body has its own materials.
  !> Requires: a new object. Local.
  subroutine create(self, problem, constants)
    class(joined_body_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> of find_body_constants
    type(body_constants_t), intent(in) :: constants(:)
    integer :: i, i_body

    self%body = problem%body
    self%constants = constants
    allocate (self%starts(size(constants) + 1), source=0)
    allocate (self%moduli(0), self%ratios(0))
    do i = 1, size(constants)
      self%moduli = [self%moduli, constants(i)%moduli]
      self%ratios = [self%ratios, constants(i)%ratios]
      self%starts(i + 1) = size(self%moduli)
    end do
    do i = 1, size(self%body%material_of_cell)
      if (self%body%material_of_cell(i) <= 0) cycle
      i_body = body_of_cell(problem, i)
      self%body%material_of_cell(i) = self%starts(i_body) + &
        findloc(constants(i_body)%materials, problem%body%material_of_cell(i), dim=1)
    end do
    if (allocated(self%body%flows)) self%body%flows = &
      [(problem%body%flows(constants(i)%materials), i=1, size(constants))]
    call self%body%set_moduli(self%moduli, self%ratios)
  end subroutine create

  !> Sets in self (moduli, ratios and body) the elastic constants of one body from the values of its variables. Its first modulus
  !> and the constants that do not vary stay, and so do those of all other bodies.
  subroutine set(self, problem, i_body, values)
    class(joined_body_t), intent(inout) :: self
    type(problem_t), intent(in) :: problem
    !> number of the body, 1-based
    integer, intent(in) :: i_body
    !> values of the variables of this body: to_constant turns them into constants; shape (n_variables)
    real(rk), intent(in) :: values(:)
    real(rk) :: value(size(values))
    integer :: i, i_material, i_term

    associate (constants => self%constants(i_body))
      value = to_constant(values, constants%denominators > 0, constants%is_logarithmic)
      do i = 1, size(values)
        ! moduli are 1, 3, ... of the constants
        i_term = findloc(problem%constant_terms, constants%numerators(i), dim=1)
        i_material = self%starts(i_body) + findloc(constants%materials, (i_term + 1) / 2, dim=1)
        if (constants%denominators(i) > 0) then
          self%moduli(i_material) = value(i) * self%moduli(self%starts(i_body) + 1)
        else
          self%ratios(i_material) = value(i)
        end if
      end do
    end associate
    call self%body%set_moduli(self%moduli, self%ratios)
  end subroutine set
end module sig_body_constants
