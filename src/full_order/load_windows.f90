! SPDX-License-Identifier: BSD-3-Clause
!> Finds loads that act on nothing: no part of their surface is in their window or, with load: whole_edges, no whole facet.
module sig_load_windows
  use sig_deck_box, only: names_of
  use sig_deck_config, only: deck_config_t, load_config_t, value_config_t
  use sig_errors, only: error_t, make_error
  use sig_expression, only: expression_t
  use sig_facet_points, only: window_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_t, nodes_of_facet
  use sig_mesh_checks, only: group_of_surface
  use sig_parameter_space, only: format_point
  use sig_text, only: append_text, short_number, string_t, to_text
  use sig_window_rule, only: facet_box, facet_outside, facet_position
  implicit none(type, external)
  private
  public :: check_fixed_windows, window_warnings

  !> The boxes of the facets of a surface.
  type :: boxes_t
    !> [length] smallest and largest coordinates of each facet, shape (n_dim, n_facets)
    real(rk), allocatable :: lower(:, :)
    real(rk), allocatable :: upper(:, :)
  end type boxes_t

contains

  !> Checks the windows without parameters. Errors: the first window in which nothing of its surface is loaded; an unknown surface.
  subroutine check_fixed_windows(deck, mesh, error)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable, intent(out) :: error
    type(boxes_t) :: boxes
    real(rk), allocatable :: bounds(:, :)
    integer :: i

    do i = 1, size(deck%loads)
      associate (load => deck%loads(i))
        if (load%axis == 0 .or. depends_on_parameters(load)) cycle
        call find_boxes(deck, mesh, load, boxes, error)
        if (allocated(error)) return
        bounds = bounds_at(deck, load, reshape([real(rk) ::], [size(deck%state_parameters), 1], pad=[0.0_rk]))
        if (is_met(boxes, load, bounds(:, 1))) cycle
        call make_error(error, 'the window of loads[' // to_text(i) // '] loads nothing of ''' // load%target%text // ''': ' // &
          extent_text(deck, load, boxes), deck%path, load%target%line, load%target%column, &
          facets_needed(load) // ' must be in the window: change its axis or its bounds')
        return
      end associate
    end do
  end subroutine check_fixed_windows

  !> Returns a warning for each load whose window depends on the parameters and loads nothing at one or more of the points.
  function window_warnings(deck, mesh, points) result(warnings)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable :: warnings(:)
    type(boxes_t) :: boxes
    type(error_t), allocatable :: error
    real(rk), allocatable :: bounds(:, :)
    logical :: is_missed(size(points, 2))
    integer :: i, k

    allocate (warnings(0))
    do i = 1, size(deck%loads)
      associate (load => deck%loads(i))
        if (load%axis == 0 .or. .not. depends_on_parameters(load)) cycle
        call find_boxes(deck, mesh, load, boxes, error)
        if (allocated(error)) cycle
        bounds = bounds_at(deck, load, points)
        is_missed = [(.not. is_met(boxes, load, bounds(:, k)), k=1, size(points, 2))]
        if (.not. any(is_missed)) cycle
        k = findloc(is_missed, .true., dim=1)
        call append_text(warnings, 'the window of loads[' // to_text(i) // '] loads nothing of ''' // load%target%text // &
          ''' at ' // to_text(count(is_missed)) // ' of ' // to_text(size(is_missed)) // ' points, for instance at ' // &
          format_point(deck%state_parameters, points(:, k)) // ': the window has ' // window_text(deck, load, bounds(:, k)) // &
          ', and ' // extent_text(deck, load, boxes))
      end associate
    end do
  end function window_warnings

  pure logical function depends_on_parameters(load)
    type(load_config_t), intent(in) :: load

    depends_on_parameters = .not. (load%minimum%is_constant .and. load%maximum%is_constant)
  end function depends_on_parameters

  !> Computes the boxes of the facets of a load's surface. Errors: the mesh does not have the surface.
  subroutine find_boxes(deck, mesh, load, boxes, error)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(load_config_t), intent(in) :: load
    type(boxes_t), intent(out) :: boxes
    type(error_t), allocatable, intent(out) :: error
    integer :: i, i_group

    call group_of_surface(mesh, load%target, deck%path, i_group, error)
    if (allocated(error)) return
    associate (facets => mesh%groups(i_group)%entities)
      allocate (boxes%lower(mesh%n_dim, size(facets)), boxes%upper(mesh%n_dim, size(facets)))
      do i = 1, size(facets)
        call facet_box(mesh%coordinates(:, nodes_of_facet(mesh, facets(i))), load%is_cut, boxes%lower(:, i), boxes%upper(:, i))
      end do
    end associate
  end subroutine find_boxes

  !> [length] Returns minimum and maximum of a load's window at each point, shape (2, n_points); huge numbers for no bound, and a
  !> bound that is not finite counts as none.
  function bounds_at(deck, load, points) result(bounds)
    type(deck_config_t), intent(in) :: deck
    type(load_config_t), intent(in) :: load
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    real(rk) :: bounds(2, size(points, 2))

    bounds(1, :) = -huge(bounds)
    bounds(2, :) = huge(bounds)
    if (load%has_minimum) call evaluate_bound(deck, load%minimum, points, bounds(1, :))
    if (load%has_maximum) call evaluate_bound(deck, load%maximum, points, bounds(2, :))
  end function bounds_at

  !> Computes a bound at each point; where it is not finite the value stays.
  subroutine evaluate_bound(deck, bound, points, values)
    type(deck_config_t), intent(in) :: deck
    type(value_config_t), intent(in) :: bound
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> [length] shape (n_points)
    real(rk), intent(inout) :: values(:)
    type(expression_t) :: expression
    character(:), allocatable :: message
    real(rk) :: value
    integer :: i
    logical :: is_valid

    call expression%create(bound%text, names_of(deck%state_parameters), message)
    do i = 1, size(values)
      call expression%evaluate(points(:, i), value, is_valid)
      if (is_valid) values(i) = value
    end do
    call expression%destroy()
  end subroutine evaluate_bound

  !> Whether the window, with these bounds, loads a facet.
  pure logical function is_met(boxes, load, bounds)
    type(boxes_t), intent(in) :: boxes
    type(load_config_t), intent(in) :: load
    !> [length] minimum and maximum
    real(rk), intent(in) :: bounds(2)
    integer :: i

    is_met = .true.
    do i = 1, size(boxes%lower, 2)
      if (facet_position(boxes%lower(:, i), boxes%upper(:, i), window_t(load%axis, bounds(1), bounds(2), load%is_cut)) &
        /= facet_outside) return
    end do
    is_met = .false.
  end function is_met

  !> Returns the bounds that the window has: `min 0.0 mm and max 3.0 mm`.
  pure function window_text(deck, load, bounds) result(text)
    type(deck_config_t), intent(in) :: deck
    type(load_config_t), intent(in) :: load
    !> [length] minimum and maximum
    real(rk), intent(in) :: bounds(2)
    character(:), allocatable :: text

    text = ''
    if (load%has_minimum) text = 'min ' // short_number(bounds(1)) // ' ' // deck%units%length
    if (load%has_minimum .and. load%has_maximum) text = text // ' and '
    if (load%has_maximum) text = text // 'max ' // short_number(bounds(2)) // ' ' // deck%units%length
  end function window_text

  !> Returns where the surface is along the axis of the window: `'top' lies between z = 0.0 and 4.0 mm`, or `'top' lies at z = 4.0
  !> mm`.
  pure function extent_text(deck, load, boxes) result(text)
    type(deck_config_t), intent(in) :: deck
    type(load_config_t), intent(in) :: load
    type(boxes_t), intent(in) :: boxes
    character(:), allocatable :: text

    associate (low => minval(boxes%lower(load%axis, :)), high => maxval(boxes%upper(load%axis, :)))
      text = '''' // load%target%text // ''' lies at '
      if (high > low) text = '''' // load%target%text // ''' lies between '
      text = text // load%axes(load%axis) // ' = ' // short_number(low)
      if (high > low) text = text // ' and ' // short_number(high)
    end associate
    text = text // ' ' // deck%units%length
  end function extent_text

  pure function facets_needed(load) result(text)
    type(load_config_t), intent(in) :: load
    character(:), allocatable :: text

    text = 'a part of the surface'
    if (.not. load%is_cut) text = 'with load: whole_edges, at least one whole facet of the surface'
  end function facets_needed
end module sig_load_windows
