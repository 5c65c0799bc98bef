! SPDX-License-Identifier: BSD-3-Clause
!> Checks whether a problem can be solved at given points of its parameters, before any of them is solved.
module sig_point_checks
  use sig_errors, only: error_t, make_error
  use sig_flow_checks, only: check_flow_properties
  use sig_idle_loads, only: check_idle_loads
  use sig_kinds, only: rk
  use sig_materials, only: check_materials
  use sig_parameter_space, only: format_point
  use sig_problem, only: problem_t
  use sig_problem_texts, only: tags_text
  use sig_rounding, only: rounding
  use sig_sparse_friction, only: check_clearance
  use sig_term_values, only: evaluate_points
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: check_points

contains

  !> Checks points before they are solved. The checks follow one another, each at all points. Errors: the first point where an
  !> elastic constant that depends on the parameters is not finite or out of its range; else where a term (prescribed value, load,
  !> gap, imposed strain) is not finite; else where a property of a material that flows is out of its range; else where loads do
  !> work on an idle motion (check_idle_loads); else where a body has a clearance that the solver cannot follow (check_clearance);
  !> else where an inert pair penetrates, or a prescribed node its obstacle. Local.
  subroutine check_points(problem, points, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: theta(:, :)
    integer :: i_bad_point, i_bad_source, i_point

    if (.not. problem%has_fixed_stiffness) call check_materials(problem%deck, problem%material_terms, points, error)
    if (allocated(error)) return
    call evaluate_points(problem%terms, points, theta, i_bad_point, i_bad_source)
    if (i_bad_point > 0) then
      call refuse_point(problem, points(:, i_bad_point), i_bad_source, error)
      return
    end if
    call check_flow_properties(problem, points, error)
    if (allocated(error)) return
    call check_idle_loads(problem, points, theta, error)
    if (allocated(error)) return
    call check_clearance(problem, points, theta, error)
    if (allocated(error) .or. problem%inert%n_rows == 0) return
    do i_point = 1, size(points, 2)
      call check_inert_pairs(problem, points(:, i_point), theta(:, i_point), error)
      if (allocated(error)) return
    end do
  end subroutine check_points

  !> Makes the error that names the expression without a finite value, and the point. For a surface load with a window, the message
  !> says that the load or a bound of the window is not finite.
  subroutine refuse_point(problem, point, i_source, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> index in problem%terms%sources, 1-based
    integer, intent(in) :: i_source
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: of_window

    of_window = ''
    associate (source => problem%terms%sources(i_source))
      if (source%axis > 0) of_window = ' or a bound of its window'
      call make_error(error, 'the expression ''' // source%text // '''' // of_window // ' is not finite at ' // &
        format_point(problem%deck%state_parameters, point), problem%deck%path, source%line, source%column, &
        'change it or the range of the parameters')
    end associate
  end subroutine refuse_point

  !> Checks the gaps of the inert pairs at one point, which follow from prescribed values alone. Errors: the first pair that
  !> penetrates by more than rounding.
  subroutine check_inert_pairs(problem, point, theta, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> [-] values of the problem's terms there, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    type(error_t), allocatable, intent(out) :: error
    real(rk) :: displacement(problem%mesh%n_dim * problem%mesh%n_nodes), opening(problem%inert%n_rows), gap(problem%inert%n_rows)
    integer :: k

    displacement = problem%boundary%prescribed_displacement(theta)
    gap = matmul(problem%inert%gap, theta)
    opening = gap - problem%inert%apply(displacement)
    do k = 1, problem%inert%n_rows
      if (opening(k) >= -rounding * max(abs(gap(k)), maxval(abs(displacement)))) cycle
      associate (contact => problem%deck%contact(problem%inert%contact_entry(k)))
        call make_error(error, 'the prescribed displacements and the gap press ' // pressed_text(problem, k, &
          to_text(-opening(k)) // ' ' // problem%deck%units%length) // ' at ' // &
          format_point(problem%deck%state_parameters, point) // &
          '; the displacements there are prescribed, so no contact force can change this', problem%deck%path, &
          contact%first%line, contact%first%column, &
          'the gap there is ' // to_text(gap(k)) // ' ' // problem%deck%units%length // &
          ': change it or the prescribed displacements, or narrow the parameter range')
      end associate
      return
    end do
  end subroutine check_inert_pairs

  !> Returns `nodes 3 and 8 of the contact surfaces 0.1 m into each other` or `node 3 0.1 m into the obstacle`, with the numbers in
  !> the mesh file of all nodes of the row.
  pure function pressed_text(problem, k, depth) result(text)
    type(problem_t), intent(in) :: problem
    !> number of the inert row, 1-based
    integer, intent(in) :: k
    !> with its unit, such as 0.1 m
    character(*), intent(in) :: depth
    character(:), allocatable :: text

    associate (inert => problem%inert, tags => problem%mesh%node_tags)
      if (size(inert%second_nodes_of(k)) > 0) then
        text = 'nodes ' // tags_text(tags(inert%nodes_of(k)), ' and ') // ' of the contact surfaces ' // depth // ' into each other'
      else
        text = 'node ' // tags_text(tags(inert%nodes_of(k)), ' and ') // ' ' // depth // ' into the obstacle'
      end if
    end associate
  end function pressed_text
end module sig_point_checks
