! SPDX-License-Identifier: BSD-3-Clause
!> Answers of a reduced model at parameter points: a complementarity problem of the domain's multipliers and two small products.
module sig_query
  use sig_bits, only: unpack_bits
  use sig_kinds, only: rk
  use sig_lcp, only: find_other_solution, lcp_active_set, lcp_lemke, lcp_method_name, lcp_reason_text, lcp_solution_t, lcp_solved, &
    lcp_workspace_t, solve_lcp
  use sig_linear_algebra, only: multiply
  use sig_online_model, only: online_model_t
  use sig_solution_choice, only: solution_choice_t
  use sig_term_values, only: term_values_t
  implicit none(type, external)
  private
  public :: query_t, answer_t, method_name, reason_text

  !> methods of an answer: those of sig_lcp, and
  integer, parameter, public :: query_condensed = lcp_lemke + 1
  integer, parameter, public :: n_query_methods = query_condensed

  !> reasons of an answer beside those of sig_lcp: > 0 answered, < 0 not
  integer, parameter, public :: query_answered = lcp_solved
  !> the point has not one value per parameter
  integer, parameter, public :: query_failed_size = -11
  !> a term of the model is infinite or not a number there
  integer, parameter, public :: query_failed_term = -12

  !> Answer at one point; where there is none the arrays are zero.
  type :: answer_t
    !> cluster that answered, 1-based
    integer :: cluster = 1
    !> [length] gamma, shape (n_modes)
    real(rk), allocatable :: coordinates(:)
    !> [force] lambda on the reduced integration domain, shape (n_rows)
    real(rk), allocatable :: multipliers_rid(:)
    !> lambda > 0, shape (n_rows)
    logical, allocatable :: is_active(:)
    !> [force] lambda on all contacts where the method is query_condensed, shape (n_multipliers)
    real(rk), allocatable :: multipliers(:)
    !> one of sig_lcp's methods, or query_condensed: the reduced problem has no solution, the full-order operator of the model
    !> answered; method_name says it in words
    integer :: method = 0
    !> query_answered, one of query_failed_* or one of sig_lcp's; reason_text says it in words
    integer :: reason = query_failed_size
    !> linear solves and pivots
    integer :: n_iterations = 0
    !> the point lies in the trained box; an answer is given outside too
    logical :: is_inside_box = .false.
    !> [-] to the nearest training point, the box taken as of side 1
    real(rk) :: distance = huge(1.0_rk)
    !> [-] largest violation of the contact conditions of the problem that was solved, relative to the terms of its row
    real(rk) :: residual = huge(1.0_rk)
    !> solutions of the reduced problem that two starts found, 0 without an answer; 2: it has several, and the forces are doubtful
    integer :: n_solutions = 0
    !> values of the model's terms, shape (n_terms)
    real(rk), allocatable :: theta(:)
  end type answer_t

  !> Room and expressions of one thread. After the first answers a query allocates nothing.
  type :: query_t
    private
    type(term_values_t) :: terms
    type(lcp_workspace_t) :: workspace
    type(lcp_solution_t) :: solution
    type(lcp_solution_t) :: other_solution
    type(lcp_solution_t) :: full_order_solution
    type(solution_choice_t) :: choice
    !> (q, free coordinates), shape (n_rows + n_modes of the largest cluster, at least n_multipliers)
    real(rk), allocatable :: response(:)
    logical, allocatable :: start(:)
  contains
    procedure :: create
    procedure :: evaluate
    procedure :: destroy
  end type query_t

contains

  !> Errors: message is allocated when a term is no expression.
  subroutine create(self, online, message)
    class(query_t), intent(inout) :: self
    !> prepared
    type(online_model_t), intent(in) :: online
    character(:), allocatable, intent(out) :: message
    integer :: n, n_multipliers

    call self%destroy()
    call self%terms%create(online%model%terms, message)
    if (allocated(message)) return
    n_multipliers = online%model%n_multipliers
    n = max(n_multipliers, maxval(online%systems%n_rows + online%systems%n_modes))
    allocate (self%response(n), self%start(max(n_multipliers, maxval(online%systems%n_rows))))
  end subroutine create

  !> Answers at one point. The starts depend on the point alone: where an answer is not unique it must not depend on the one before.
  subroutine evaluate(self, online, point, answer, cluster, starts)
    class(query_t), intent(inout) :: self
    !> the model of create
    type(online_model_t), intent(in) :: online
    !> values of the parameters in the model's order
    real(rk), intent(in) :: point(:)
    type(answer_t), intent(inout) :: answer
    !> to be asked whatever the point; default: the model's choice
    integer, intent(in), optional :: cluster
    !> two active sets to start from, as bits, shape (n_words(n_rows), 2); default: those of training points around the point
    integer, intent(in), optional :: starts(:, :)
    integer :: i_nearest, i_opposite, i_source
    logical :: is_valid

    answer%cluster = 1
    if (size(point) == size(online%model%box, 2)) answer%cluster = online%model%choice%cluster_of(point)
    if (present(cluster)) answer%cluster = cluster
    call start_answer(online, answer)
    if (size(point) /= size(online%model%box, 2)) return
    answer%is_inside_box = online%is_inside_box(point)
    call online%nearest_point(point, i_nearest, answer%distance)
    call self%terms%evaluate(point, answer%theta, is_valid, i_source)
    answer%reason = merge(query_answered, query_failed_term, is_valid)
    if (.not. is_valid) return
    if (present(starts)) then
      call solve_reduced(self, online, starts, 1, 2, answer)
    else
      call online%opposite_point(point, i_nearest, i_opposite)
      call solve_reduced(self, online, online%model%clusters(answer%cluster)%start_sets, i_nearest, i_opposite, answer)
    end if
    if (answer%reason < 0 .and. online%model%full_order%has_multipliers()) call solve_full_order(self, online, answer)
    if (answer%reason < 0) return
    associate (system => online%systems(answer%cluster))
      answer%coordinates = self%response(system%n_rows + 1:system%n_rows + system%n_modes)
      call multiply(-1.0_rk, system%multiplier_response, answer%multipliers_rid, 1.0_rk, answer%coordinates)
    end associate
  end subroutine evaluate

  !> Zeros in arrays of the right size.
  pure subroutine start_answer(online, answer)
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(inout) :: answer

    associate (system => online%systems(answer%cluster))
      call resize(answer%theta, online%model%terms%n_terms())
      call resize(answer%coordinates, system%n_modes)
      call resize(answer%multipliers_rid, system%n_rows)
      call resize(answer%multipliers, online%model%n_multipliers)
      if (allocated(answer%is_active)) then
        if (size(answer%is_active) /= system%n_rows) deallocate (answer%is_active)
      end if
      if (.not. allocated(answer%is_active)) allocate (answer%is_active(system%n_rows))
    end associate
    answer%is_active = .false.
    answer%method = 0
    answer%reason = query_failed_size
    answer%n_iterations = 0
    answer%is_inside_box = .false.
    answer%distance = huge(answer%distance)
    answer%residual = huge(answer%residual)
    answer%n_solutions = 0
  end subroutine start_answer

  !> Zeros.
  pure subroutine resize(values, n)
    real(rk), allocatable, intent(inout) :: values(:)
    integer, intent(in) :: n

    if (allocated(values)) then
      if (size(values) /= n) deallocate (values)
    end if
    if (.not. allocated(values)) allocate (values(n))
    values = 0
  end subroutine resize

  !> The complementarity problem of the domain, from two active sets; without sets from what penetrates.
  subroutine solve_reduced(self, online, sets, i_first, i_second, answer)
    class(query_t), intent(inout) :: self
    type(online_model_t), intent(in) :: online
    !> as bits, shape (n_words(n_rows), n_sets)
    integer, intent(in) :: sets(:, :)
    !> of them, 0 = none
    integer, intent(in) :: i_first
    integer, intent(in) :: i_second
    type(answer_t), intent(inout) :: answer

    associate (system => online%systems(answer%cluster))
      call multiply(1.0_rk, system%response, answer%theta, 0.0_rk, self%response(:size(system%response, 1)))
      associate (q => self%response(:system%n_rows), start => self%start(:system%n_rows))
        if (i_first >= 1 .and. i_first <= size(sets, 2)) then
          call unpack_bits(sets(:, i_first), start)
        else
          start = q < 0
        end if
        call solve_lcp(system%condensed, q, start, self%solution, self%workspace)
      end associate
    end associate
    call take_reduced(self%solution, answer)
    if (answer%reason < 0 .or. i_second < 1 .or. max(i_first, i_second) > size(sets, 2)) return
    if (any(sets(:, i_second) /= sets(:, i_first))) call look_for_other(self, online, sets(:, i_second), answer)
  end subroutine solve_reduced

  !> A second solution of the domain's problem, from another active set. The full-order operator of the model, if there is one,
  !> says which is the answer; else the first one stays.
  subroutine look_for_other(self, online, set, answer)
    class(query_t), intent(inout) :: self
    type(online_model_t), intent(in) :: online
    !> as bits, shape (n_words(n_rows))
    integer, intent(in) :: set(:)
    !> that of the first start
    type(answer_t), intent(inout) :: answer
    integer :: n_before
    logical :: is_found

    n_before = answer%n_iterations
    associate (system => online%systems(answer%cluster))
      associate (q => self%response(:system%n_rows), start => self%start(:system%n_rows), &
        free_coordinates => self%response(system%n_rows + 1:system%n_rows + system%n_modes))
        call unpack_bits(set, start)
        call find_other_solution(system%condensed, q, start, self%solution, self%other_solution, self%workspace, is_found)
        if (is_found .and. online%model%full_order%has_multipliers()) then
          if (self%choice%is_other_better(online, answer%cluster, answer%theta, free_coordinates, self%solution, &
            self%other_solution)) call take_reduced(self%other_solution, answer)
        end if
      end associate
    end associate
    if (is_found) answer%n_solutions = 2
    answer%n_iterations = n_before + self%other_solution%n_iterations
  end subroutine look_for_other

  pure subroutine take_reduced(solution, answer)
    type(lcp_solution_t), intent(in) :: solution
    type(answer_t), intent(inout) :: answer

    call take_solution(solution, solution%method, answer)
    answer%multipliers_rid = solution%lambda
    answer%is_active = solution%is_active
  end subroutine take_reduced

  !> The complementarity problem of all contacts: W is positive semidefinite, so that it has a solution.
  !>
  !> The free coordinates in self%response stay: the displacement is then that of the reduced model under the true multipliers
  !> unless the model holds more.
  subroutine solve_full_order(self, online, answer)
    class(query_t), intent(inout) :: self
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(inout) :: answer
    integer :: n_before

    n_before = answer%n_iterations
    associate (q => answer%multipliers, start => self%start(:online%model%n_multipliers))
      call multiply(1.0_rk, online%model%full_order%free_opening, answer%theta, 0.0_rk, q)
      start = q < 0
      call solve_lcp(online%model%full_order%compliance, q, start, self%full_order_solution, self%workspace)
      q = self%full_order_solution%lambda
    end associate
    call take_solution(self%full_order_solution, query_condensed, answer)
    answer%n_iterations = n_before + answer%n_iterations
    answer%multipliers_rid = answer%multipliers(online%model%clusters(answer%cluster)%contact_rows)
    answer%is_active = answer%multipliers_rid > 0
  end subroutine solve_full_order

  pure subroutine take_solution(solution, method, answer)
    type(lcp_solution_t), intent(in) :: solution
    integer, intent(in) :: method
    type(answer_t), intent(inout) :: answer

    answer%method = method
    answer%reason = solution%reason
    answer%n_iterations = solution%n_iterations
    answer%residual = solution%residual
    answer%n_solutions = merge(1, 0, solution%reason > 0)
  end subroutine take_solution

  subroutine destroy(self)
    class(query_t), intent(inout) :: self

    call self%terms%destroy()
    if (allocated(self%response)) deallocate (self%response, self%start)
  end subroutine destroy

  !> A method as in reports and tables.
  pure function method_name(method) result(name)
    integer, intent(in) :: method
    character(:), allocatable :: name

    name = 'condensed'
    if (method < query_condensed) name = lcp_method_name(method)
  end function method_name

  !> Reason of an answer as a sentence without its full stop.
  pure function reason_text(reason) result(text)
    integer, intent(in) :: reason
    character(:), allocatable :: text

    select case (reason)
    case (query_failed_size)
      text = 'the point has not one value per parameter'
    case (query_failed_term)
      text = 'a term of the model is infinite or not a number at this point'
    case default
      text = 'the complementarity problem ' // lcp_reason_text(reason)
    end select
  end function reason_text
end module sig_query
