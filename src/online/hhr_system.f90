! SPDX-License-Identifier: BSD-3-Clause
!> The equations (10) of a hyper-reduced model condensed on the multipliers of its domain. They are made once or, where the
!> stiffness depends on the parameters, at each point.
!>
!> If only contact holds a body and the snapshots contain its rigid motion, K_r is singular, because a rigid motion has no
!> stiffness. Then as many rows T as there are such motions, the anchors, exchange force and opening: the opening becomes the
!> unknown. With K' = K_r + s M_T' M_T, which is regular, and F' = F + s M_T' D_T, (10) is the same as K' gamma + M' (lambda + s w
!> on T) = F' for the openings w = D - M gamma, so w = W' (lambda + s w on T) + q'. A principal pivot on T makes w_T the unknowns
!> and lambda_T their complementary values:
!>
!>   lambda_T = A (1 - s A^-1) w_T - A W'_TR lambda_R - A q'_T,   A = W'_TT^-1
!>   w_R = W'_RT A w_T + (W'_RR - W'_RT A W'_TR) lambda_R + q'_R - W'_RT A q'_T
!>
!> This is a complementarity problem again. It is exact, whether K_r is singular or not.
module sig_hhr_system
  use sig_hhr_data, only: add_lifted, hhr_data_t
  use sig_dense_kernels, only: add_product, factor_lu, reciprocal_condition_lu, solve_lu
  use sig_kinds, only: rk
  use sig_linear_algebra, only: invert, lu_t, multiply, singular_reciprocal
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: hhr_system_t, held_stiffness

  type :: hhr_system_t
    !> T: rows whose unknown is their opening over `scale`; the complementary value is their force times `scale`
    integer, allocatable :: anchors(:)
    !> [length/force]
    real(rk) :: scale = 1
    !> [force/length] s
    real(rk) :: spring = 0
    !> W = M K_r^-1 M', with anchors the matrix of the new problem (exchange); shape (n_rows, n_rows)
    real(rk), allocatable :: condensed(:, :)
    !> (q, K_r^-1 F) = response theta with q = D - M K_r^-1 F, shape (n_rows + n_modes, n_terms); with anchors q of the new problem,
    !> and K'^-1 F'
    real(rk), allocatable :: response(:, :)
    !> gamma = K_r^-1 F - multiplier_response lambda, shape (n_modes, n_rows); with anchors gamma = K'^-1 F' - multiplier_response
    !> (lambda + s w on T)
    real(rk), allocatable :: multiplier_response(:, :)
    !> work arrays of systems that are made at each point: factors of K_r (with anchors, of K'), the varying part of the load per
    !> lifted term, and others
    real(rk), allocatable, private :: factors(:, :)
    real(rk), allocatable, private :: lifting_load(:, :)
    real(rk), allocatable, private :: moduli(:)
    real(rk), allocatable, private :: work(:)
    integer, allocatable, private :: pivots(:)
    integer, allocatable, private :: signs(:)
  contains
    procedure :: create
    procedure :: reserve
    procedure :: assemble
    procedure :: forces_of
    procedure :: coordinates
    procedure, private :: exchange
  end type hhr_system_t

contains

  !> Makes the system of a cluster whose stiffness does not depend on the parameters. Errors: message is allocated, and there is no
  !> system, when the reduced stiffness, with springs on the anchors, or W'_TT is numerically singular.
  subroutine create(self, cluster, message)
    class(hhr_system_t), intent(inout) :: self
    type(hhr_data_t), intent(in) :: cluster
    character(:), allocatable, intent(out) :: message
    type(lu_t) :: lu
    logical :: is_singular

    self%anchors = cluster%anchors
    self%spring = spring_of(cluster, cluster%reduced_stiffness)
    call lu%factor(held_stiffness(cluster, cluster%reduced_stiffness))
    if (lu%is_singular) then
      message = 'the reduced stiffness (' // to_text(cluster%n_modes) // ' modes) is numerically singular: its reciprocal ' &
        // 'condition number is ' // to_text(lu%reciprocal_condition) // '; the equations of the reduced integration domain ' &
        // 'do not determine every mode; take a larger pod_tolerance or add a zone of interest'
      return
    end if
    self%multiplier_response = lu%solve(transpose(cluster%contact_matrix))
    self%condensed = matmul(cluster%contact_matrix, self%multiplier_response)
    if (allocated(self%response)) deallocate (self%response)
    allocate (self%response(cluster%n_rows + cluster%n_modes, size(cluster%load, 2)))
    self%response(cluster%n_rows + 1:, :) = cluster%load
    if (size(self%anchors) > 0) self%response(cluster%n_rows + 1:, :) = cluster%load + held_load(self, cluster)
    self%response(cluster%n_rows + 1:, :) = lu%solve(self%response(cluster%n_rows + 1:, :))
    self%response(:cluster%n_rows, :) = cluster%gap - matmul(cluster%contact_matrix, self%response(cluster%n_rows + 1:, :))
    if (size(self%anchors) == 0) return
    call self%exchange(self%response(:cluster%n_rows, :), is_singular)
    if (is_singular) message = 'the reduced equations do not determine the forces of the contacts that hold the bodies; take ' // &
      'more training points or add a zone of interest'
  end subroutine create

  !> Returns the spring stiffness s [force/length]: the largest absolute value in K_r over the largest squared norm of a row of M
  !> of an anchor; 0 without anchors.
  pure real(rk) function spring_of(cluster, stiffness) result(spring)
    type(hhr_data_t), intent(in) :: cluster
    real(rk), intent(in) :: stiffness(:, :)

    spring = 0
    if (size(cluster%anchors) == 0) return
    spring = maxval(abs(stiffness)) / maxval(sum(cluster%contact_matrix(cluster%anchors, :)**2, dim=2))
  end function spring_of

  !> Returns K' [force/length], which is K_r with springs on the anchors; K_r itself without anchors.
  pure function held_stiffness(cluster, stiffness) result(held)
    type(hhr_data_t), intent(in) :: cluster
    !> [force/length] K_r, shape (n_modes, n_modes)
    real(rk), intent(in) :: stiffness(:, :)
    real(rk) :: held(size(stiffness, 1), size(stiffness, 2))

    held = stiffness
    if (size(cluster%anchors) == 0) return
    associate (rows => cluster%contact_matrix(cluster%anchors, :))
      held = held + spring_of(cluster, stiffness) * matmul(transpose(rows), rows)
    end associate
  end function held_stiffness

  !> Returns s M_T' D_T [force per unit of theta], the load by the springs, for each term.
  pure function held_load(self, cluster) result(load)
    type(hhr_system_t), intent(in) :: self
    type(hhr_data_t), intent(in) :: cluster
    real(rk) :: load(cluster%n_modes, size(cluster%load, 2))

    load = self%spring * matmul(transpose(cluster%contact_matrix(self%anchors, :)), cluster%gap(self%anchors, :))
  end function held_load

  !> Makes the principal pivot on T: W' and q' of K' become the matrix and the constant part of the new problem, whose unknowns on T
  !> are openings over `scale`. It also sets `scale`. Requires: anchors.
  subroutine exchange(self, columns, is_singular)
    !> in: W'; out: the matrix of the new problem
    class(hhr_system_t), intent(inout) :: self
    !> [length] in: q', one per column, shape (n_rows, n_columns); out: those of the new problem
    real(rk), intent(inout) :: columns(:, :)
    !> whether W'_TT is numerically singular; nothing is changed then
    logical, intent(out) :: is_singular
    real(rk) :: inverse(size(self%anchors), size(self%anchors)), reach(size(columns, 1), size(self%anchors))
    real(rk) :: own(size(self%anchors), size(columns, 1)), q(size(self%anchors), size(columns, 2))
    integer :: i

    associate (t => self%anchors, w => self%condensed)
      call invert(w(t, t), inverse, is_singular)
      if (is_singular) return
      reach = matmul(w(:, t), inverse)
      own = w(t, :)
      q = columns(t, :)
      w = w - matmul(reach, own)
      self%scale = 1 / self%spring
      if (size(w, 1) > size(t)) self%scale = sum([(abs(w(i, i)), i=1, size(w, 1))]) / (size(w, 1) - size(t))
      if (.not. self%scale > 0) self%scale = 1 / self%spring
      w(:, t) = self%scale * reach
      w(t, :) = -self%scale * matmul(inverse, own)
      w(t, t) = self%scale**2 * inverse
      do i = 1, size(t)
        w(t(i), t(i)) = w(t(i), t(i)) - self%scale**2 * self%spring
      end do
      columns = columns - matmul(reach, q)
      columns(t, :) = -self%scale * matmul(inverse, q)
    end associate
  end subroutine exchange

  !> Converts the unknowns of the complementarity problem to the forces of all rows, and to the forces that act in the equations of
  !> K'. An anchor with an unknown above 0 is open and has the force 0. The force of any other anchor is its complementary value
  !> over `scale`, at least 0.
  subroutine forces_of(self, unknowns, response, forces, held_forces)
    class(hhr_system_t), intent(in) :: self
    !> [force] unknowns of the complementarity problem, shape (n_rows)
    real(rk), contiguous, intent(in) :: unknowns(:)
    !> (q, coordinates without contact forces) at the point, shape (n_rows + n_modes)
    real(rk), contiguous, intent(in) :: response(:)
    !> [force] lambda, shape (n_rows)
    real(rk), contiguous, intent(inout) :: forces(:)
    !> [force] lambda + s w on T, shape (n_rows)
    real(rk), contiguous, intent(inout) :: held_forces(:)
    integer :: i, k

    forces = unknowns
    held_forces = unknowns
    do i = 1, size(self%anchors)
      associate (row => self%anchors(i))
        forces(row) = 0
        if (.not. unknowns(row) > 0) then
          forces(row) = response(row)
          do k = 1, size(unknowns)
            forces(row) = forces(row) + self%condensed(row, k) * unknowns(k)
          end do
          forces(row) = max(0.0_rk, forces(row)) / self%scale
        end if
        held_forces(row) = forces(row) + self%spring * self%scale * unknowns(row)
      end associate
    end do
  end subroutine forces_of

  !> Allocates the work arrays for assemble, and copies the list of the anchors. Requires: a new system.
  pure subroutine reserve(self, cluster)
    class(hhr_system_t), intent(inout) :: self
    type(hhr_data_t), intent(in) :: cluster

    associate (n => cluster%n_modes, n_rows => cluster%n_rows)
      allocate (self%condensed(n_rows, n_rows), self%multiplier_response(n, n_rows), self%factors(n, n))
      allocate (self%lifting_load(n, size(cluster%lifted_terms)), self%work(n), self%pivots(n), self%signs(n))
      allocate (self%moduli(size(cluster%varying%kinds)))
      self%anchors = cluster%anchors
    end associate
  end subroutine reserve

  !> Makes the system at a point, for a cluster whose stiffness depends on the parameters. The cost is about 2/3 n_modes^3 +
  !> 2 n_modes^2 (n_rows + number of moduli) + 2 n_modes n_rows^2 operations. Requires: reserve, has_material of sig_hhr_stiffness.
  subroutine assemble(self, cluster, theta, response, is_singular)
    class(hhr_system_t), target, intent(inout) :: self
    !> the data that reserve was called with
    type(hhr_data_t), intent(in) :: cluster
    !> values of the model's terms
    real(rk), contiguous, intent(in) :: theta(:)
    !> out: (q, K_r^-1 F) at the point, with anchors (q of the new problem, K'^-1 F'); shape (n_rows + n_modes)
    real(rk), contiguous, intent(inout) :: response(:)
    !> whether K_r, with springs on the anchors, or W'_TT is numerically singular; there is no system then
    logical, intent(out) :: is_singular
    real(rk), pointer, contiguous :: flat(:)
    real(rk) :: column(cluster%n_rows, merge(1, 0, size(self%anchors) > 0)), norm
    integer :: i, info

    call cluster%varying%moduli_at(theta, self%moduli)
    associate (n => cluster%n_modes, n_rows => cluster%n_rows)
      self%factors = cluster%reduced_stiffness
      flat(1:n**2) => self%factors
      call multiply(1.0_rk, cluster%varying%parts, self%moduli, 1.0_rk, flat)
      self%spring = spring_of(cluster, self%factors)
      if (size(self%anchors) > 0) self%factors = held_stiffness(cluster, self%factors)
      norm = maxval([0.0_rk, (sum(abs(self%factors(:, i))), i=1, n)])
      call factor_lu(n, self%factors, self%pivots, info)
      is_singular = info /= 0
      if (.not. is_singular) is_singular = .not. reciprocal_condition_lu(n, self%factors, norm, self%work, self%signs) > &
        singular_reciprocal
      if (is_singular) return
      do i = 1, n_rows
        self%multiplier_response(:, i) = cluster%contact_matrix(i, :)
      end do
      call solve_lu(n, self%factors, self%pivots, self%multiplier_response)
      self%condensed = 0
      call add_product(1.0_rk, cluster%contact_matrix, self%multiplier_response, self%condensed)
      flat(1:size(self%lifting_load)) => self%lifting_load
      call multiply(1.0_rk, cluster%varying%lifting_parts, self%moduli, 0.0_rk, flat)
      call load_at(cluster, theta, self%lifting_load, response(n_rows + 1:))
      if (size(self%anchors) > 0) call multiply(1.0_rk, held_load(self, cluster), theta, 1.0_rk, response(n_rows + 1:))
      call solve_lu(n, self%factors, self%pivots, response(n_rows + 1:))
      call multiply(1.0_rk, cluster%gap, theta, 0.0_rk, response(:n_rows))
      call multiply(-1.0_rk, cluster%contact_matrix, response(n_rows + 1:), 1.0_rk, response(:n_rows))
      if (size(self%anchors) == 0) return
      column(:, 1) = response(:n_rows)
      call self%exchange(column, is_singular)
      response(:n_rows) = column(:, 1)
    end associate
  end subroutine assemble

  !> Computes F [force] of the reduced equations in `load`, shape (n_modes), without springs on the anchors.
  subroutine load_at(cluster, theta, lifting_load, load)
    type(hhr_data_t), intent(in) :: cluster
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] the varying part, shape (n_modes, n_lifted_terms)
    real(rk), contiguous, intent(in) :: lifting_load(:, :)
    real(rk), contiguous, intent(inout) :: load(:)

    call multiply(1.0_rk, cluster%load, theta, 0.0_rk, load)
    call add_lifted(cluster, 1.0_rk, lifting_load, theta, load)
  end subroutine load_at

  !> Computes gamma [length], the coordinates of the modes under the loads and the forces of the domain.
  subroutine coordinates(self, response, multipliers, values)
    class(hhr_system_t), intent(in) :: self
    !> (q, coordinates without contact forces) at the point, shape (n_rows + n_modes); q is not used
    real(rk), intent(in) :: response(:)
    !> [force] held_forces of forces_of: lambda + s w on T, lambda elsewhere; shape (n_rows)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> [length] shape (n_modes)
    real(rk), contiguous, intent(inout) :: values(:)

    values = response(size(multipliers) + 1:)
    call multiply(-1.0_rk, self%multiplier_response, multipliers, 1.0_rk, values)
  end subroutine coordinates
end module sig_hhr_system
