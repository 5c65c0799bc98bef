! SPDX-License-Identifier: BSD-3-Clause
!> Elastic constants that may be expressions of the parameters: their values at a point, and what these must satisfy.
module sig_materials
  use sig_deck_config, only: deck_config_t, point_set_config_t, value_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_parameter_space, only: build_states, find_states, format_point
  use sig_point_batches, only: count_distinct
  use sig_term_set, only: start_terms, term_set_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: add_material_terms, create_material_terms, set_materials, check_materials, has_fixed_stiffness
  public :: most_chosen_states, most_points_per_stiffness, varying_constants

contains

  !> Makes a term set of the elastic constants of the deck. Term 1 is the constant 1, terms 2, 4, ... are the Young's moduli
  !> [force/length**2] in the order of the deck's materials, terms 3, 5, ... the Poisson's ratios [-].
  pure subroutine create_material_terms(deck, parameter_names, terms)
    type(deck_config_t), intent(in) :: deck
    type(string_t), intent(in) :: parameter_names(:)
    type(term_set_t), intent(out) :: terms
    integer, allocatable :: numbers(:)

    call start_terms(parameter_names, [string_t ::], .false., terms)
    call add_material_terms(deck, terms, numbers)
  end subroutine create_material_terms

  !> Adds Young's modulus and Poisson's ratio of each material of the deck to a term set, each as a new term at its end.
  pure subroutine add_material_terms(deck, terms, numbers)
    type(deck_config_t), intent(in) :: deck
    type(term_set_t), intent(inout) :: terms
    !> indices of the terms: modulus and ratio of the first material, of the second, ...; shape (2 * n_materials)
    integer, allocatable, intent(out) :: numbers(:)
    integer :: i

    allocate (numbers(2 * size(deck%materials)))
    do i = 1, size(deck%materials)
      associate (e => deck%materials(i)%young_modulus, nu => deck%materials(i)%poisson_ratio)
        call terms%add_expression(e%text, e%line, e%column, numbers(2 * i - 1))
        call terms%add_expression(nu%text, nu%line, nu%column, numbers(2 * i))
      end associate
    end do
  end subroutine add_material_terms

  !> Gives the bodies the elastic constants of a point, which are not checked here. Requires: they are finite and in their ranges
  !> (check_materials). Local.
  subroutine set_materials(terms, point, body)
    !> of create_material_terms
    type(term_set_t), intent(in) :: terms
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    type(elastic_body_t), intent(inout) :: body
    real(rk), allocatable :: values(:, :)
    integer :: i_bad_point, i_bad_source

    call evaluate_points(terms, reshape(point, [size(point), 1]), values, i_bad_point, i_bad_source)
    call body%set_moduli(values(2::2, 1), values(3::2, 1))
  end subroutine set_materials

  !> Whether no elastic constant depends on the parameters.
  pure logical function has_fixed_stiffness(deck)
    type(deck_config_t), intent(in) :: deck
    integer :: i

    has_fixed_stiffness = all([(deck%materials(i)%young_modulus%is_constant .and. deck%materials(i)%poisson_ratio%is_constant, &
      i=1, size(deck%materials))])
  end function has_fixed_stiffness

  !> Returns Young's modulus and Poisson's ratio of all materials at each point; points with equal columns have the same stiffness.
  !> The result has no rows if no constant depends on the parameters. If a value is not finite, the column of this point is
  !> incomplete, and the columns of all later points are zero: check_materials comes first.
  function varying_constants(deck, terms, points) result(constants)
    type(deck_config_t), intent(in) :: deck
    !> of create_material_terms
    type(term_set_t), intent(in) :: terms
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> values of all terms of create_material_terms, shape (1 + 2 * n_materials, n_points), or (0, n_points)
    real(rk), allocatable :: constants(:, :)
    integer :: i_bad_point, i_bad_source

    if (has_fixed_stiffness(deck)) then
      allocate (constants(0, size(points, 2)))
    else
      call evaluate_points(terms, points, constants, i_bad_point, i_bad_source)
    end if
  end function varying_constants

  !> Returns how many points share a stiffness: for each set of points of the deck, the number of points over the number of
  !> different stiffnesses, rounded down; of these values the largest one. The sets are those of output, of training (whose value
  !> counts with at most greedy.max_points), of the candidates of the clusters, and of test. Sets that cannot be read do not count.
  !> 0 without points.
  integer function most_points_per_stiffness(deck, terms) result(n)
    type(deck_config_t), intent(in) :: deck
    !> of create_material_terms
    type(term_set_t), intent(in) :: terms
    real(rk), allocatable :: states(:, :)
    type(error_t), allocatable :: error

    call find_states(deck, deck%output%points, states, error)
    n = 0
    if (.not. allocated(error)) n = per_stiffness(deck, terms, states)
    if (deck%has_training) n = max(n, min(n_points_of(deck, terms, deck%training), most_chosen_states(deck)))
    if (deck%clusters%target%is_used) n = max(n, n_points_of(deck, terms, deck%clusters%target%candidates))
    if (deck%has_test) n = max(n, n_points_of(deck, terms, deck%test))
  end function most_points_per_stiffness

  !> Returns the largest number of states that a greedy selection may choose; huge without a limit.
  pure integer function most_chosen_states(deck) result(n)
    type(deck_config_t), intent(in) :: deck

    n = max(1, deck%history%states%n_times())
    n = n * min(deck%greedy%max_points, huge(n) / n)
  end function most_chosen_states

  !> Returns the number of points per stiffness of one set, rounded down; 0 if the points cannot be read.
  integer function n_points_of(deck, terms, point_set) result(n)
    type(deck_config_t), intent(in) :: deck
    type(term_set_t), intent(in) :: terms
    type(point_set_config_t), intent(in) :: point_set
    real(rk), allocatable :: points(:, :)
    type(error_t), allocatable :: error

    n = 0
    call build_states(deck, point_set, points, error)
    if (allocated(error)) return
    n = per_stiffness(deck, terms, points)
  end function n_points_of

  integer function per_stiffness(deck, terms, points) result(n)
    type(deck_config_t), intent(in) :: deck
    type(term_set_t), intent(in) :: terms
    real(rk), intent(in) :: points(:, :)

    n = size(points, 2) / max(1, count_distinct(varying_constants(deck, terms, points)))
  end function per_stiffness

  !> Checks the elastic constants of all materials at points. Errors: the first Young's modulus that is not finite or not above 0,
  !> or Poisson's ratio that is not finite or not between -1 and 0.5 (both excluded), in the order of points, then of materials. The
  !> message names its line of the deck and the point.
  subroutine check_materials(deck, terms, points, error)
    type(deck_config_t), intent(in) :: deck
    !> of create_material_terms
    type(term_set_t), intent(in) :: terms
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: values(:, :)
    integer :: i, i_bad_point, i_bad_source, i_point
    character(:), allocatable :: unit

    unit = ' ' // deck%units%force // '/' // deck%units%length // '^2'
    call evaluate_points(terms, points, values, i_bad_point, i_bad_source)
    do i_point = 1, size(points, 2)
      do i = 1, size(deck%materials)
        associate (material => deck%materials(i), e => values(2 * i, i_point), nu => values(2 * i + 1, i_point))
          if (i_point == i_bad_point .and. i_bad_source == 2 * i - 1) then
            call refuse('young_modulus', material%young_modulus, 'not finite', 'it must be greater than 0')
          else if (i_point == i_bad_point .and. i_bad_source == 2 * i) then
            call refuse('poisson_ratio', material%poisson_ratio, 'not finite', 'it must lie between -1 and 0.5')
          else if (e <= 0) then
            call refuse('young_modulus', material%young_modulus, to_text(e) // unit, 'it must be greater than 0')
          else if (nu <= -1 .or. nu >= 0.5_rk) then
            call refuse('poisson_ratio', material%poisson_ratio, to_text(nu), 'it must lie between -1 and 0.5')
          end if
        end associate
        if (allocated(error)) return
      end do
    end do

  contains

    subroutine refuse(key, value, found, wanted)
      character(*), intent(in) :: key
      type(value_config_t), intent(in) :: value
      character(*), intent(in) :: found
      character(*), intent(in) :: wanted

      call make_error(error, 'materials.' // deck%materials(i)%name // '.' // key // ' is ''' // value%text // ''', which is ' // &
        found // ' at ' // format_point(deck%state_parameters, points(:, i_point)) // '; ' // wanted, deck%path, &
        value%line, value%column)
    end subroutine refuse
  end subroutine check_materials
end module sig_materials
