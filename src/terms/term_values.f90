! SPDX-License-Identifier: BSD-3-Clause
!> Values of the terms theta_t at parameter points. The texts of a term set are compiled once and evaluated at every point.
module sig_term_values
  use sig_expression, only: expression_t
  use sig_facet_points, only: facet_rule_t, window_t
  use sig_kinds, only: rk
  use sig_term_set, only: source_expression, source_places, source_surface, term_set_t, term_source_t
  use sig_text, only: string_t
  use sig_window_rule, only: facet_box, facet_cut, facet_inside, facet_position, find_facet_rule
  implicit none(type, external)
  private
  public :: term_values_t, evaluate_points, facet_forces

  real(rk), parameter :: pi = 3.14159265358979323846264338327950288_rk

  !> Data of one facet of a surface load, the same at every point.
  type :: facet_table_t
    integer :: n_nodes = 0
    !> [length] smallest and largest coordinates, by facet_box, shape (n_dim)
    real(rk), allocatable :: lower(:)
    real(rk), allocatable :: upper(:)
    !> [length] coordinates of the nodes, shape (n_dim, n_nodes)
    real(rk), allocatable :: vertices(:, :)
    !> terms of the nodal forces, 0 = none, shape (n_dim, n_nodes)
    integer, allocatable :: dof_terms(:, :)
    !> nodal forces of the whole facet under the load value 1, in length**(n_dim - 1), axisymmetric length**2; (n_dim, n_nodes)
    real(rk), allocatable :: unit_forces(:, :)
  end type facet_table_t

  !> Expressions of one source, and the facets of a surface load.
  type :: handles_t
    type(expression_t) :: value
    type(expression_t) :: minimum
    type(expression_t) :: maximum
    logical :: has_minimum = .false.
    logical :: has_maximum = .false.
    !> the load value does not depend on the coordinates
    logical :: is_uniform = .false.
    type(facet_table_t), allocatable :: facets(:)
  end type handles_t

  !> A term set with compiled expressions, for one thread at a time. A copy shares the expressions: destroy only one of both.
  type :: term_values_t
    private
    type(term_set_t) :: terms
    type(handles_t), allocatable :: handles(:)
    !> work space that is used again at the next point: values of the parameters, then of the coordinates
    real(rk), allocatable :: arguments(:)
    type(facet_rule_t) :: rule
  contains
    procedure :: create
    procedure :: evaluate
    procedure :: scales
    procedure :: destroy
  end type term_values_t

contains

  !> Copies `terms`, compiles their expressions, and integrates each whole facet of the surface loads for the load value 1. Errors:
  !> message is allocated when a text is not a valid expression; then nothing is compiled. What was compiled before is freed.
  subroutine create(self, terms, message)
    class(term_values_t), intent(inout) :: self
    type(term_set_t), intent(in) :: terms
    character(:), allocatable, intent(out) :: message
    integer :: i

    call self%destroy()
    self%terms = terms
    allocate (self%handles(size(terms%sources)))
    allocate (self%arguments(size(terms%parameter_names) + size(terms%coordinate_names)), source=0.0_rk)
    do i = 1, size(self%handles)
      call create_handles(terms, terms%sources(i), self%handles(i), message)
      if (allocated(message)) exit
    end do
    if (allocated(message)) call self%destroy()
  end subroutine create

  subroutine create_handles(terms, source, handles, message)
    type(term_set_t), intent(in) :: terms
    type(term_source_t), intent(in) :: source
    type(handles_t), intent(inout) :: handles
    character(:), allocatable, intent(out) :: message
    type(string_t), allocatable :: names(:)

    if (source%kind == source_expression) then
      allocate (names, source=terms%parameter_names)
    else
      allocate (names, source=[terms%parameter_names, terms%coordinate_names])
    end if
    call handles%value%create(source%text, names, message, is_composed=.true.)
    if (allocated(message)) then
      message = 'the term ''' // source%text // ''' of the model: ' // message
      return
    end if
    handles%has_minimum = len(source%minimum) > 0
    handles%has_maximum = len(source%maximum) > 0
    if (handles%has_minimum) call handles%minimum%create(source%minimum, terms%parameter_names, message)
    if (handles%has_maximum .and. .not. allocated(message)) &
      call handles%maximum%create(source%maximum, terms%parameter_names, message)
    if (allocated(message)) then
      message = 'a window of the model: ' // message
    else if (source%kind == source_surface) then
      call tabulate_facets(terms, source, handles)
    end if
  end subroutine create_handles

  !> Stores box, nodes and nodal forces under the load value 1 of each facet of a surface load, and whether the load is uniform.
  subroutine tabulate_facets(terms, source, handles)
    type(term_set_t), intent(in) :: terms
    type(term_source_t), intent(in) :: source
    type(handles_t), intent(inout) :: handles
    type(expression_t) :: one
    type(facet_rule_t) :: rule
    character(:), allocatable :: message
    logical :: is_valid
    integer :: i

    call one%create('1', terms%coordinate_names, message)
    handles%is_uniform = .not. any([(handles%value%uses(terms%coordinate_names(i)%text), i=1, size(terms%coordinate_names))])
    allocate (handles%facets(size(source%facets, 2)))
    do i = 1, size(handles%facets)
      associate (facet => handles%facets(i))
        facet%n_nodes = count(source%facets(:, i) > 0)
        facet%vertices = source%places(:, source%facets(:facet%n_nodes, i))
        facet%dof_terms = source%dof_terms(:, source%facets(:facet%n_nodes, i))
        allocate (facet%lower(size(facet%vertices, 1)), facet%upper(size(facet%vertices, 1)))
        call facet_box(facet%vertices, source%is_cut, facet%lower, facet%upper)
        call find_facet_rule(facet%vertices, window_t(), rule)
        call facet_forces(rule, source%component, source%orientations(i), terms%is_round, one, [real(rk) ::], &
          facet%unit_forces, is_valid)
      end associate
    end do
    call one%destroy()
  end subroutine tabulate_facets

  !> Returns for each term a size to which the rounding error of its value is proportional: |theta|, or for a nodal force of a
  !> surface the sum of |theta| over this surface, because the end of a window is rounded as a coordinate of the whole surface is.
  pure function scales(self, theta)
    class(term_values_t), intent(in) :: self
    !> values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> shape (n_terms)
    real(rk) :: scales(size(theta))
    integer, allocatable :: forces(:)
    integer :: i, k
    real(rk) :: total

    scales = abs(theta)
    do i = 1, size(self%terms%sources)
      associate (source => self%terms%sources(i))
        if (source%kind /= source_surface) cycle
        forces = pack(source%dof_terms, source%dof_terms > 0)
      end associate
      total = sum(abs(theta(forces)))
      do k = 1, size(forces)
        scales(forces(k)) = max(scales(forces(k)), total)
      end do
    end do
  end function scales

  !> Computes the values of all terms at one point. If a value or a bound of a window is infinite or not a number, is_valid is
  !> false, i_source says which source gave it, and theta is incomplete. Requires: create.
  subroutine evaluate(self, point, theta, is_valid, i_source)
    class(term_values_t), intent(inout) :: self
    !> values of the parameters, shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> values of the terms, shape (n_terms)
    real(rk), intent(out) :: theta(:)
    logical, intent(out) :: is_valid
    !> first source without a finite value, 1-based; 0 = none
    integer, intent(out) :: i_source
    integer :: i

    theta = 0
    theta(1) = 1
    is_valid = .true.
    i_source = 0
    self%arguments(:size(point)) = point
    do i = 1, size(self%handles)
      select case (self%terms%sources(i)%kind)
      case (source_expression)
        call add_value(self%terms%sources(i)%terms(1), self%handles(i)%value, point, theta, is_valid)
      case (source_places)
        call add_places(self%terms%sources(i), self%handles(i)%value, self%arguments, theta, is_valid)
      case default
        call add_surface(self, i, point, theta, is_valid)
      end select
      if (is_valid) cycle
      i_source = i
      return
    end do
  end subroutine evaluate

  subroutine add_value(i_term, expression, values, theta, is_valid)
    integer, intent(in) :: i_term
    type(expression_t), intent(in) :: expression
    real(rk), intent(in) :: values(:)
    real(rk), intent(inout) :: theta(:)
    logical, intent(out) :: is_valid
    real(rk) :: value

    call expression%evaluate(values, value, is_valid)
    theta(i_term) = theta(i_term) + value
  end subroutine add_value

  subroutine add_places(source, expression, arguments, theta, is_valid)
    type(term_source_t), intent(in) :: source
    type(expression_t), intent(in) :: expression
    !> values of the parameters, then room for the coordinates
    real(rk), intent(inout) :: arguments(:)
    real(rk), intent(inout) :: theta(:)
    logical, intent(out) :: is_valid
    integer :: i

    is_valid = .true.
    do i = 1, size(source%terms)
      arguments(size(arguments) - size(source%places, 1) + 1:) = source%places(:, i)
      call add_value(source%terms(i), expression, arguments, theta, is_valid)
      if (.not. is_valid) return
    end do
  end subroutine add_places

  !> Adds the nodal forces of a surface load to theta. is_valid: load and bounds have finite values; else theta is incomplete.
  subroutine add_surface(self, i_source, point, theta, is_valid)
    class(term_values_t), intent(inout) :: self
    integer, intent(in) :: i_source
    real(rk), intent(in) :: point(:)
    real(rk), intent(inout) :: theta(:)
    logical, intent(out) :: is_valid
    type(window_t) :: window
    real(rk) :: value
    integer :: i, position

    associate (source => self%terms%sources(i_source), handles => self%handles(i_source))
      window%axis = source%axis
      window%is_cut = source%is_cut
      value = 0
      is_valid = .true.
      if (handles%has_minimum) call handles%minimum%evaluate(point, window%minimum, is_valid)
      if (handles%has_maximum .and. is_valid) call handles%maximum%evaluate(point, window%maximum, is_valid)
      if (handles%is_uniform .and. is_valid) call handles%value%evaluate(self%arguments, value, is_valid)
      do i = 1, size(handles%facets)
        if (.not. is_valid) return
        associate (facet => handles%facets(i))
          position = facet_position(facet%lower, facet%upper, window)
          if (position == facet_inside .and. handles%is_uniform) then
            call add_nodal_forces(facet%dof_terms, value, facet%unit_forces, theta)
          else if (position == facet_inside .or. position == facet_cut) then
            call find_facet_rule(facet%vertices, window, self%rule)
            call add_facet(self, i_source, i, value, theta, is_valid)
          end if
        end associate
      end do
    end associate
  end subroutine add_surface

  pure subroutine add_nodal_forces(dof_terms, factor, forces, theta)
    !> term of each component of each node of the facet, 0 = none
    integer, intent(in) :: dof_terms(:, :)
    real(rk), intent(in) :: factor
    real(rk), intent(in) :: forces(:, :)
    real(rk), intent(inout) :: theta(:)
    integer :: j, k

    do j = 1, size(forces, 2)
      do k = 1, size(forces, 1)
        if (dof_terms(k, j) > 0) theta(dof_terms(k, j)) = theta(dof_terms(k, j)) + factor * forces(k, j)
      end do
    end do
  end subroutine add_nodal_forces

  !> Adds to theta the forces on one facet, by the points of self%rule. is_valid: all load values are finite; else theta lacks some.
  subroutine add_facet(self, i_source, i_facet, value, theta, is_valid)
    class(term_values_t), intent(inout) :: self
    integer, intent(in) :: i_source
    integer, intent(in) :: i_facet
    !> value of the load where it is uniform; not used elsewhere
    real(rk), intent(in) :: value
    real(rk), intent(inout) :: theta(:)
    logical, intent(out) :: is_valid
    real(rk) :: force(3), local
    integer :: i, j, k, n_dim

    is_valid = .true.
    local = value
    associate (source => self%terms%sources(i_source), handles => self%handles(i_source), &
      facet => self%handles(i_source)%facets(i_facet))
      n_dim = size(facet%vertices, 1)
      do i = 1, self%rule%n_points
        if (.not. handles%is_uniform) then
          self%arguments(size(self%arguments) - n_dim + 1:) = self%rule%places(:, i)
          call handles%value%evaluate(self%arguments, local, is_valid)
          if (.not. is_valid) return
        end if
        call point_force(self%rule, i, source%component, source%orientations(i_facet), self%terms%is_round, force)
        do j = 1, facet%n_nodes
          do k = 1, n_dim
            if (facet%dof_terms(k, j) > 0) theta(facet%dof_terms(k, j)) = theta(facet%dof_terms(k, j)) &
              + local * force(k) * self%rule%values(j, i)
          end do
        end do
      end do
    end associate
  end subroutine add_facet

  !> Computes the force of the load value 1 at point i of a rule, times its weight; arguments and units as in facet_forces.
  pure subroutine point_force(rule, i, component, orientation, is_round, force)
    type(facet_rule_t), intent(in) :: rule
    integer, intent(in) :: i
    integer, intent(in) :: component
    integer, intent(in) :: orientation
    logical, intent(in) :: is_round
    real(rk), intent(out) :: force(3)

    force = 0
    if (component > 0) then
      force(component) = norm2(rule%area_vectors(:, i))
    else
      force(:size(rule%area_vectors, 1)) = -orientation * rule%area_vectors(:, i)
    end if
    if (is_round) force = force * 2 * pi * rule%places(1, i)
  end subroutine point_force

  !> Computes the nodal forces on one facet of a pressure, which acts against the outward normal, or of one component of a traction.
  !> If the load has no finite value at a point of the rule, is_valid is false and forces are incomplete. Without points they are 0.
  subroutine facet_forces(rule, component, orientation, is_round, expression, point, forces, is_valid)
    !> integration points of the facet
    type(facet_rule_t), intent(in) :: rule
    !> 0 = pressure, else component of the traction
    integer, intent(in) :: component
    !> +1 where the normal of the rule points outward, else -1
    integer, intent(in) :: orientation
    !> axisymmetric: multiply by 2 pi times the first coordinate
    logical, intent(in) :: is_round
    !> value of the load; its variables are the parameters, then the coordinates
    type(expression_t), intent(in) :: expression
    !> values of the parameters
    real(rk), intent(in) :: point(:)
    !> [unit of the load times length**(n_dim - 1); axisymmetric: times length**2] shape (n_dim, n_nodes)
    real(rk), allocatable, intent(out) :: forces(:, :)
    logical, intent(out) :: is_valid
    real(rk) :: force(3), value
    integer :: i, j

    is_valid = .true.
    allocate (forces(size(rule%places, 1), size(rule%values, 1)), source=0.0_rk)
    do i = 1, rule%n_points
      call expression%evaluate([point, rule%places(:, i)], value, is_valid)
      if (.not. is_valid) return
      call point_force(rule, i, component, orientation, is_round, force)
      do j = 1, size(forces, 2)
        forces(:, j) = forces(:, j) + value * rule%values(j, i) * force(:size(forces, 1))
      end do
    end do
  end subroutine facet_forces

  !> Frees the expressions; it may be called without create.
  subroutine destroy(self)
    class(term_values_t), intent(inout) :: self
    integer :: i

    if (.not. allocated(self%handles)) return
    do i = 1, size(self%handles)
      call self%handles(i)%value%destroy()
      call self%handles(i)%minimum%destroy()
      call self%handles(i)%maximum%destroy()
    end do
    deallocate (self%handles, self%arguments)
  end subroutine destroy

  !> Computes the values of all terms at several points. The texts must be valid expressions, as the deck layer checks. At the first
  !> value that is not finite the work stops: i_bad_point and i_bad_source name it, and theta is incomplete.
  subroutine evaluate_points(terms, points, theta, i_bad_point, i_bad_source)
    type(term_set_t), intent(in) :: terms
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> shape (n_terms, n_points)
    real(rk), allocatable, intent(out) :: theta(:, :)
    !> first point, and first source there, without a finite value, 1-based; 0 = none
    integer, intent(out) :: i_bad_point
    integer, intent(out) :: i_bad_source
    type(term_values_t) :: values
    character(:), allocatable :: message
    logical :: is_valid

    integer :: i

    i_bad_point = 0
    i_bad_source = 0
    allocate (theta(terms%n_terms(), size(points, 2)), source=0.0_rk)
    call values%create(terms, message)
    do i = 1, size(points, 2)
      call values%evaluate(points(:, i), theta(:, i), is_valid, i_bad_source)
      if (is_valid) cycle
      i_bad_point = i
      exit
    end do
    call values%destroy()
  end subroutine evaluate_points
end module sig_term_values
