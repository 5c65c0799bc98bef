! SPDX-License-Identifier: BSD-3-Clause
!> Warnings of contacts that act far from where curved surfaces touch, along normals that the other surface does not have there.
module sig_leaning_contacts
  use sig_contact_summary, only: contact_name
  use sig_deck_config, only: name_config_t
  use sig_kinds, only: rk
  use sig_leaning_rows, only: mean_lean, measure_leans
  use sig_mesh, only: find_group
  use sig_problem, only: problem_t, surface_of_side
  use sig_smooth_normals, only: normal_of_row
  use sig_surface_geometry, only: direction_text, flat_direction, is_flat, measure_surface, surface_geometry_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: lean_warnings, predicted_lean_warnings

  !> [-] errors of forces that are worth a warning
  real(rk), parameter :: largest_error = 0.01_rk
  !> [-] error of the force over the mean of tan(a)**2 (sig_leaning_rows)
  real(rk), parameter :: error_per_lean = 2.0_rk

contains

  !> Returns a text for each contact entry of the deck: a warning if its forces lean so far from the normals of its other surface
  !> that they err by more than about 1 % at a point, else ''. Entries with a direction or an obstacle have no warning.
  function lean_warnings(problem, multipliers) result(warnings)
    type(problem_t), intent(in) :: problem
    !> [force] normal forces, then others; shape (at least n_rows, n_points)
    real(rk), intent(in) :: multipliers(:, :)
    type(string_t), allocatable :: warnings(:)
    real(rk) :: leans(problem%rows%n_rows), means(size(problem%deck%contact)), commons(problem%mesh%n_dim, size(means))
    integer :: i

    call measure_all(problem, leans, commons)
    means = 0
    do i = 1, size(multipliers, 2)
      means = max(means, mean_leans(problem, leans, multipliers(:problem%rows%n_rows, i)))
    end do
    warnings = warnings_of(problem, means, commons)
  end function lean_warnings

  !> Returns the texts of lean_warnings before anything is solved, for forces that are predicted from the deck alone: as on a bed
  !> of springs they are the areas of the rows times their overlaps, if the bodies move by the largest prescribed displacements and
  !> do not deform. Motions by loads are not known; they add nothing.
  function predicted_lean_warnings(problem, points) result(warnings)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points); check_points accepted them
    real(rk), intent(in) :: points(:, :)
    type(string_t), allocatable :: warnings(:)
    real(rk), allocatable :: theta(:, :), reach(:, :)
    real(rk) :: leans(problem%rows%n_rows), means(size(problem%deck%contact)), commons(problem%mesh%n_dim, size(means))
    integer :: i, i_bad_point, i_bad_source

    call measure_all(problem, leans, commons)
    reach = reach_of_terms(problem)
    means = 0
    call evaluate_points(problem%terms, points, theta, i_bad_point, i_bad_source)
    associate (rows => problem%rows)
      do i = 1, size(points, 2)
        means = max(means, mean_leans(problem, leans, rows%areas * max(0.0_rk, &
          matmul(reach, abs(theta(:size(reach, 2), i))) - matmul(rows%gap, theta(:, i)))))
      end do
    end associate
    warnings = warnings_of(problem, means, commons)
  end function predicted_lean_warnings

  !> Computes tan(a)**2 of each row and the common normal of each contact entry (measure_leans); 0 for entries with a direction or
  !> an obstacle.
  subroutine measure_all(problem, leans, commons)
    type(problem_t), intent(in) :: problem
    !> [-] shape (n_rows)
    real(rk), intent(out) :: leans(:)
    !> [-] shape (n_dim, size(deck%contact))
    real(rk), intent(out) :: commons(:, :)
    integer :: i, side

    leans = 0
    commons = 0
    do i = 1, size(problem%deck%contact)
      if (problem%deck%contact(i)%has_direction .or. problem%deck%contact(i)%has_obstacle) cycle
      call measure_leans(problem%mesh, problem%rows, i, [(group_of_side(problem, i, side), side=1, 2)], &
        problem%boundary%is_prescribed, leans, commons(:, i))
    end do
  end subroutine measure_all

  !> [-] Returns the mean of tan(a)**2 over the rows of each contact entry at one point.
  pure function mean_leans(problem, leans, forces) result(means)
    type(problem_t), intent(in) :: problem
    !> [-] shape (n_rows)
    real(rk), intent(in) :: leans(:)
    !> in any unit, >= 0, shape (n_rows)
    real(rk), intent(in) :: forces(:)
    real(rk) :: means(size(problem%deck%contact))
    integer :: i

    do i = 1, size(means)
      associate (own => merge(forces, 0.0_rk, problem%rows%contact_entry == i))
        means(i) = mean_lean(leans, own)
      end associate
    end do
  end function mean_leans

  !> Returns the warnings of contact entries with these means of tan(a)**2.
  function warnings_of(problem, means, commons) result(warnings)
    type(problem_t), intent(in) :: problem
    !> [-] shape (size(deck%contact))
    real(rk), intent(in) :: means(:)
    !> [-] common normals, shape (n_dim, size(deck%contact))
    real(rk), intent(in) :: commons(:, :)
    type(string_t), allocatable :: warnings(:)
    integer :: i

    allocate (warnings(size(means)))
    do i = 1, size(means)
      warnings(i)%text = ''
      if (error_per_lean * means(i) > largest_error) warnings(i)%text = lean_text(problem, i, means(i), commons(:, i))
    end do
  end function warnings_of

  !> Returns the text of a warning, with the direction that the deck should give: the normal of a flat surface, else the common one.
  function lean_text(problem, i_entry, lean, common) result(text)
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: i_entry
    !> [-] mean of tan(a)**2
    real(rk), intent(in) :: lean
    !> [-] from the surface with the multipliers to the other one
    real(rk), intent(in) :: common(:)
    character(:), allocatable :: text
    type(surface_geometry_t) :: geometry
    real(rk) :: direction(size(common))

    call measure_surface(problem%mesh, group_of_side(problem, i_entry, 2), geometry)
    direction = common
    if (is_flat(geometry)) direction = flat_direction(geometry)
    if (problem%is_swapped(i_entry)) direction = -direction
    text = 'contact[' // to_text(i_entry) // '] (' // contact_name(problem%deck, i_entry) // ') reaches far beyond where its ' // &
      'surfaces touch: contact forces lean by about ' // to_text(nint(atan(sqrt(lean)) * 180 / acos(-1.0_rk))) // &
      ' degrees and may be too small by about ' // to_text(nint(100 * error_per_lean * lean)) // &
      ' %, because the normals of the mesh are not right there; give direction: ' // direction_text(direction) // ' in this entry'
  end function lean_text

  !> [length per unit of theta] Returns by how much each term of the prescribed displacements can close each row: the normal's
  !> components in size, times the largest difference of prescribed displacements along each. Shape (n_rows, number of terms).
  pure function reach_of_terms(problem) result(reach)
    type(problem_t), intent(in) :: problem
    real(rk), allocatable :: reach(:, :)
    real(rk) :: ranges(problem%mesh%n_dim)
    integer :: c, k, t

    associate (values => problem%boundary%prescribed_values, dofs => problem%boundary%prescribed_dofs, n => problem%mesh%n_dim)
      allocate (reach(problem%rows%n_rows, size(values, 2)))
      do t = 1, size(values, 2)
        do c = 1, n
          ! a support counts even if no dof of this component is prescribed to be 0
          associate (own => pack(values(:, t), modulo(dofs - 1, n) + 1 == c))
            ranges(c) = max(0.0_rk, maxval(own)) - min(0.0_rk, minval(own))
          end associate
        end do
        do k = 1, problem%rows%n_rows
          reach(k, t) = dot_product(abs(normal_of_row(problem%rows, k)), ranges)
        end do
      end do
    end associate
  end function reach_of_terms

  pure integer function group_of_side(problem, i_entry, side) result(group)
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: i_entry
    !> 1: the surface with the multipliers
    integer, intent(in) :: side
    type(name_config_t) :: name

    name = surface_of_side(problem, i_entry, side)
    group = find_group(problem%mesh, name%text, problem%mesh%n_dim - 1)
  end function group_of_side
end module sig_leaning_contacts
