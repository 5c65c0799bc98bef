! SPDX-License-Identifier: BSD-3-Clause
!> Von Mises stresses at the integration points of cells that flow: of an answer of a reduced model, and of full-order solutions of
!> a history, of which displacements are kept and the states of the material are not. Strains decide both, so the laws find the
!> states again. Where the full order cut a step in parts, this leaves a part of its time error.
module sig_flow_stresses
  use sig_answer, only: answer_t
  use sig_elasticity, only: n_stresses, von_mises
  use sig_flow_points, only: flow_law_t, flow_points_t, flow_room_t
  use sig_flow_properties, only: compiled_properties_t
  use sig_inelastic_model, only: inelastic_model_t
  use sig_inelastic_training, only: add_strains
  use sig_kinds, only: rk
  use sig_linear_algebra, only: unit_vector
  use sig_problem, only: problem_t
  use sig_term_values, only: evaluate_points
  implicit none(type, external)
  private
  public :: answered_stresses, solved_stresses

contains

  !> [force/length**2] Returns the von Mises stresses of an answer, shape (n_points). Requires: the answer has a solution.
  function answered_stresses(model, answer, state) result(stresses)
    type(inelastic_model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    !> numbers of the state
    real(rk), intent(in) :: state(:)
    real(rk) :: stresses(model%all%n_points())
    real(rk), allocatable :: strain_theta(:, :)
    real(rk) :: total(size(model%all%components) * size(stresses)), strains(n_stresses, size(stresses))
    integer :: i, i_bad_point, i_bad_source

    call evaluate_points(model%strain_terms, reshape(state, [size(state), 1]), strain_theta, i_bad_point, i_bad_source)
    associate (points => model%all)
      call points%find_strains(answer%theta, answer%unknowns, answer%coordinates, total)
      strains = -reshape(matmul(points%imposed, strain_theta(:, 1)), shape(strains))
      strains(points%components, :) = strains(points%components, :) + &
        reshape(total, [size(points%components), size(stresses)])
      if (allocated(answer%plastic)) strains = strains - answer%plastic(:n_stresses, :)
      if (allocated(answer%creep)) strains = strains - answer%creep(:n_stresses, :)
      do i = 1, size(stresses)
        associate (first => n_stresses * (points%materials(i) - 1))
          strains(:, i) = matmul(model%hooke(:, first + 1:first + n_stresses), strains(:, i))
        end associate
      end do
    end associate
    stresses = von_mises(strains)
  end function answered_stresses

  !> Computes the von Mises stresses of full-order solutions at all times of one history.
  subroutine solved_stresses(problem, model, states, displacements, stresses)
    type(problem_t), intent(in) :: problem
    type(inelastic_model_t), intent(in) :: model
    !> shape (n_numbers, n_times)
    real(rk), intent(in) :: states(:, :)
    !> [length] of all dofs, shape (n_dofs, n_times)
    real(rk), intent(in) :: displacements(:, :)
    !> [force/length**2] shape (n_points, n_times)
    real(rk), allocatable, intent(out) :: stresses(:, :)
    type(flow_points_t) :: points
    type(flow_room_t) :: room
    type(flow_law_t), allocatable :: laws(:)
    type(compiled_properties_t) :: properties
    character(:), allocatable :: message
    real(rk), allocatable :: strain_theta(:, :)
    real(rk) :: before, none(0)
    integer :: i_bad_point, i_bad_source, i_time, t
    logical :: is_solved

    call prepare_points(problem, model, displacements, points)
    call model%make_laws(laws, message)
    call points%create_room(laws, room)
    call model%properties%compile(properties, message)
    call evaluate_points(model%strain_terms, states, strain_theta, i_bad_point, i_bad_source)
    i_time = size(states, 1) - problem%deck%history%states%n_values() + 1
    before = 0
    allocate (stresses(points%n_points(), size(states, 2)))
    do t = 1, size(states, 2)
      call properties%evaluate(states(:, t), points%materials, points%temperatures, room%properties)
      call points%update(laws, unit_vector(size(states, 2), t), strain_theta(:, t), none, none, states(i_time, t) - before, &
        room, is_solved)
      stresses(:, t) = von_mises(room%stresses)
      room%old_states = room%states
      before = states(i_time, t)
    end do
  end subroutine solved_stresses

  !> Makes points whose terms are the given displacements.
  subroutine prepare_points(problem, model, displacements, points)
    type(problem_t), intent(in) :: problem
    type(inelastic_model_t), intent(in) :: model
    real(rk), intent(in) :: displacements(:, :)
    type(flow_points_t), intent(out) :: points

    points%components = model%all%components
    points%materials = model%all%materials
    points%weights = model%all%weights
    points%imposed = model%all%imposed
    points%temperatures = model%all%temperatures
    call points%contact_blocks%complete()
    call add_strains(problem, displacements, points, points%of_terms)
    allocate (points%of_contact(size(points%of_terms, 1), 0), points%of_modes(size(points%of_terms, 1), 0))
  end subroutine prepare_points
end module sig_flow_stresses
