! SPDX-License-Identifier: BSD-3-Clause
!> Answers of a reduced model at parameter points. Everything that does not depend on the point is factored once, so that a query
!> costs a complementarity problem of the domain's multipliers and two small products.
module sig_query
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_method_name, lcp_reason_text, lcp_solution_t, lcp_solved, solve_lcp
  use sig_linear_algebra, only: lu_t
  use sig_model, only: model_t, reduced_model_t
  use sig_term_values, only: term_values_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: query_t, answer_t, is_inside_box, method_name, reason_text

  !> reasons of an answer beside those of sig_lcp: > 0 answered, < 0 not
  integer, parameter, public :: query_answered = lcp_solved
  !> the point has not one value per parameter
  integer, parameter, public :: query_failed_size = -11
  !> a term of the model is infinite or not a number there
  integer, parameter, public :: query_failed_term = -12

  !> a point counts as inside when it is beyond a side by less than this part of the side's length (rounded grid points)
  real(rk), parameter :: box_tolerance = 1.0e-9_rk

  !> What does not depend on the point, for one cluster.
  type :: cluster_system_t
    private
    !> W = M K_r^-1 M', shape (n_rows, n_rows)
    real(rk), allocatable :: condensed(:, :)
    !> q = gap_response theta: D - M K_r^-1 F, shape (n_rows, n_terms)
    real(rk), allocatable :: gap_response(:, :)
    !> gamma = load_response theta - multiplier_response lambda: K_r^-1 F and K_r^-1 M'
    real(rk), allocatable :: load_response(:, :)
    real(rk), allocatable :: multiplier_response(:, :)
  end type cluster_system_t

  !> Answer at one point.
  type :: answer_t
    !> cluster that answered, 1-based
    integer :: cluster = 1
    !> [length] gamma, shape (n_modes)
    real(rk), allocatable :: coordinates(:)
    !> [force] lambda on the reduced integration domain, shape (n_rows)
    real(rk), allocatable :: multipliers_rid(:)
    !> lambda > 0, shape (n_rows)
    logical, allocatable :: is_active(:)
    !> one of sig_lcp's methods; method_name says it in words
    integer :: method = 0
    !> query_answered, one of query_failed_* or one of sig_lcp's; reason_text says it in words
    integer :: reason = query_failed_size
    !> linear solves and pivots
    integer :: n_iterations = 0
    !> the point lies in the trained box; an answer is given outside too
    logical :: is_inside_box = .false.
    !> values of the model's terms, shape (n_terms)
    real(rk), allocatable :: theta(:)
  end type answer_t

  !> A model made ready for queries. A copy shares the expressions, so only its owner destroys it; one per thread.
  type :: query_t
    private
    type(term_values_t) :: terms
    integer :: n_terms = 0
    type(cluster_system_t), allocatable :: systems(:)
    !> shape (2, n_parameters)
    real(rk), allocatable :: box(:, :)
  contains
    procedure :: create
    procedure :: evaluate
    procedure :: destroy
  end type query_t

contains

  !> Compiles the terms and condenses each cluster on its multipliers.
  !>
  !> Errors: message is allocated when a term is no expression or a reduced stiffness is numerically singular.
  subroutine create(self, model, message)
    class(query_t), intent(inout) :: self
    type(model_t), intent(in) :: model
    character(:), allocatable, intent(out) :: message
    integer :: i_cluster

    call self%destroy()
    self%box = model%box
    self%n_terms = model%terms%n_terms()
    call self%terms%create(model%terms, message)
    allocate (self%systems(size(model%clusters)))
    do i_cluster = 1, size(model%clusters)
      if (allocated(message)) exit
      call condense(model%clusters(i_cluster), self%systems(i_cluster), message)
      if (allocated(message)) message = 'cluster ' // to_text(i_cluster) // ': ' // message
    end do
    if (allocated(message)) call self%destroy()
  end subroutine create

  subroutine condense(cluster, system, message)
    type(reduced_model_t), intent(in) :: cluster
    type(cluster_system_t), intent(out) :: system
    character(:), allocatable, intent(out) :: message
    type(lu_t) :: lu

    call lu%factor(cluster%reduced_stiffness)
    if (lu%is_singular) then
      message = 'the reduced stiffness (' // to_text(cluster%n_modes) // ' modes) is numerically singular: its reciprocal ' &
        // 'condition number is ' // to_text(lu%reciprocal_condition) // '; the equations of the reduced integration domain ' &
        // 'do not determine every mode (a larger pod_tolerance or a zone of interest mends that)'
      return
    end if
    system%multiplier_response = lu%solve(transpose(cluster%contact_matrix))
    system%load_response = lu%solve(cluster%load)
    system%condensed = matmul(cluster%contact_matrix, system%multiplier_response)
    system%gap_response = cluster%gap - matmul(cluster%contact_matrix, system%load_response)
  end subroutine condense

  !> Answers at one point; every array of the answer has its size even when there is no answer (zeros then).
  !>
  !> No warm start: where an answer is not unique it must not depend on the point before.
  subroutine evaluate(self, point, answer)
    class(query_t), intent(in) :: self
    !> values of the parameters in the model's order
    real(rk), intent(in) :: point(:)
    type(answer_t), intent(out) :: answer
    type(lcp_solution_t) :: solution
    real(rk), allocatable :: q(:)
    integer :: i_source
    logical :: is_valid
    logical, parameter :: cold_start(0) = .true.

    associate (system => self%systems(answer%cluster))
      call start_answer(self%n_terms, size(system%load_response, 1), size(system%condensed, 1), answer)
      if (size(point) /= size(self%box, 2)) return
      answer%is_inside_box = is_inside_box(self%box, point)
      call self%terms%evaluate(point, answer%theta, is_valid, i_source)
      answer%reason = merge(query_answered, query_failed_term, is_valid)
      if (.not. is_valid) return
      q = matmul(system%gap_response, answer%theta)
      call solve_lcp(system%condensed, q, cold_start, solution)
      answer%method = solution%method
      answer%reason = solution%reason
      answer%n_iterations = solution%n_iterations
      if (solution%reason < 0) return
      answer%multipliers_rid = solution%lambda
      answer%is_active = solution%is_active
      answer%coordinates = matmul(system%load_response, answer%theta) &
        - matmul(system%multiplier_response, solution%lambda)
    end associate
  end subroutine evaluate

  pure subroutine start_answer(n_terms, n_modes, n_rows, answer)
    integer, intent(in) :: n_terms
    integer, intent(in) :: n_modes
    integer, intent(in) :: n_rows
    type(answer_t), intent(inout) :: answer

    allocate (answer%theta(n_terms), answer%coordinates(n_modes), answer%multipliers_rid(n_rows), source=0.0_rk)
    allocate (answer%is_active(n_rows), source=.false.)
  end subroutine start_answer

  !> The point lies in the box or on its border.
  pure logical function is_inside_box(box, point)
    !> minimum and maximum, shape (2, n_parameters)
    real(rk), intent(in) :: box(:, :)
    real(rk), intent(in) :: point(:)
    real(rk) :: margin(size(point))

    margin = box_tolerance * (box(2, :) - box(1, :))
    is_inside_box = all(point >= box(1, :) - margin .and. point <= box(2, :) + margin)
  end function is_inside_box

  subroutine destroy(self)
    class(query_t), intent(inout) :: self

    call self%terms%destroy()
    if (allocated(self%systems)) deallocate (self%systems)
    if (allocated(self%box)) deallocate (self%box)
  end subroutine destroy

  !> Method of an answer as in reports and in validation.csv.
  pure function method_name(answer) result(name)
    type(answer_t), intent(in) :: answer
    character(:), allocatable :: name

    name = lcp_method_name(answer%method)
  end function method_name

  !> Reason of an answer as a sentence without its full stop.
  pure function reason_text(answer) result(text)
    type(answer_t), intent(in) :: answer
    character(:), allocatable :: text

    select case (answer%reason)
    case (query_failed_size)
      text = 'the point has not one value per parameter'
    case (query_failed_term)
      text = 'a term of the model is infinite or not a number at this point'
    case default
      text = 'the complementarity problem ' // lcp_reason_text(answer%reason)
    end select
  end function reason_text
end module sig_query
