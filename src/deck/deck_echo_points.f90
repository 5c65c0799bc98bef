! SPDX-License-Identifier: BSD-3-Clause
!> Writes sets of points as YAML: training and test points, and candidates of a greedy selection.
module sig_deck_echo_points
  use sig_deck_config, only: greedy_config_t, parameter_config_t, point_set_config_t
  use sig_deck_echo_words, only: count_or_word, tolerance_or_none, yaml_text
  use sig_text, only: join, string_t, to_text
  implicit none(type, external)
  private
  public :: candidate_set, point_set, training_set

contains

  !> Returns the section training as YAML, `{grid: {...}, groups: auto, stiffness: auto}`, without the key and without line end. A
  !> greedy selection stands there as `{greedy: {...}, ...}`.
  pure function training_set(greedy, points, parameters) result(yaml)
    type(greedy_config_t), intent(in) :: greedy
    !> the training points, or the candidates if greedy%is_used
    type(point_set_config_t), intent(in) :: points
    type(parameter_config_t), intent(in) :: parameters(:)
    character(:), allocatable :: yaml

    yaml = point_set(points, parameters)
    if (greedy%is_used) yaml = '{greedy: ' // greedy_choice(greedy, points, parameters) // ', ' // groups_text(points) // '}'
    yaml = yaml(:len(yaml) - 1) // ', stiffness: ' // points%stiffness // '}'
  end function training_set

  !> Returns the candidates and the settings of the greedy selection as YAML, `{candidates: {...}, indicator: projection, ...}`;
  !> `batch` only with the indicators defect and audit, `tolerance` only with others than audit.
  pure function greedy_choice(greedy, points, parameters) result(yaml)
    type(greedy_config_t), intent(in) :: greedy
    type(point_set_config_t), intent(in) :: points
    type(parameter_config_t), intent(in) :: parameters(:)
    character(:), allocatable :: yaml

    yaml = '{candidates: ' // candidate_set(points, parameters) // ', indicator: ' // greedy%indicator // ', initial: ' // &
      to_text(greedy%n_initial)
    if (greedy%indicator /= 'audit') yaml = yaml // ', tolerance: ' // tolerance_or_none(greedy%tolerance)
    yaml = yaml // ', max_points: ' // count_or_word(greedy%max_points, huge(1), 'none')
    if (greedy%indicator /= 'projection') yaml = yaml // ', batch: ' // to_text(greedy%batch)
    yaml = yaml // '}'
  end function greedy_choice

  !> Returns a set of points of any kind as YAML, without the number of groups: `{grid: {...}}`, `{sobol: 64, seed: 1}`.
  pure function candidate_set(points, parameters) result(yaml)
    type(point_set_config_t), intent(in) :: points
    type(parameter_config_t), intent(in) :: parameters(:)
    character(:), allocatable :: yaml

    yaml = '{' // kind_text(points, parameters) // '}'
  end function candidate_set

  !> Returns a set of points as YAML, `{grid: {...}, groups: auto}`.
  pure function point_set(points, parameters) result(yaml)
    type(point_set_config_t), intent(in) :: points
    type(parameter_config_t), intent(in) :: parameters(:)
    character(:), allocatable :: yaml

    yaml = '{' // kind_text(points, parameters) // ', ' // groups_text(points) // '}'
  end function point_set

  pure function groups_text(points) result(yaml)
    type(point_set_config_t), intent(in) :: points
    character(:), allocatable :: yaml

    yaml = 'groups: ' // count_or_word(points%n_groups, 0, 'auto')
  end function groups_text

  pure function kind_text(points, parameters) result(yaml)
    type(point_set_config_t), intent(in) :: points
    type(parameter_config_t), intent(in) :: parameters(:)
    character(:), allocatable :: yaml
    type(string_t) :: counts(size(parameters))
    integer :: i

    if (allocated(points%grid)) then
      do i = 1, size(parameters)
        counts(i)%text = parameters(i)%name // ': ' // to_text(points%grid(i))
      end do
      yaml = 'grid: {' // join(counts, ', ') // '}'
    else if (allocated(points%file)) then
      yaml = 'file: ' // yaml_text(points%file)
    else
      yaml = 'sobol: ' // to_text(points%n_sobol)
      if (points%n_sobol == 0) yaml = 'latin_hypercube: ' // to_text(points%n_latin_hypercube)
      yaml = yaml // ', seed: ' // to_text(points%seed)
    end if
  end function kind_text
end module sig_deck_echo_points
