! SPDX-License-Identifier: BSD-3-Clause
!> The equations (10) of a hyper-reduced model condensed on the multipliers of its domain: once and for all, or, where the stiffness
!> depends on the parameters, at each point.
module sig_hhr_system
  use sig_hhr_data, only: add_lifted, hhr_data_t
  use sig_dense_kernels, only: add_product, factor_lu, reciprocal_condition_lu, solve_lu
  use sig_kinds, only: rk
  use sig_linear_algebra, only: lu_t, multiply, singular_reciprocal
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: hhr_system_t

  type :: hhr_system_t
    !> W = M K_r^-1 M', shape (n_rows, n_rows)
    real(rk), allocatable :: condensed(:, :)
    !> (q, K_r^-1 F) = response theta with q = D - M K_r^-1 F, shape (n_rows + n_modes, n_terms)
    real(rk), allocatable :: response(:, :)
    !> gamma = K_r^-1 F - multiplier_response lambda, shape (n_modes, n_rows)
    real(rk), allocatable :: multiplier_response(:, :)
    !> room of systems that are made at each point: factors of K_r, the forces against the lifting per lifted term, and others
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
    procedure :: coordinates
  end type hhr_system_t

contains

  !> Errors: message is allocated when the reduced stiffness is numerically singular.
  subroutine create(self, cluster, message)
    class(hhr_system_t), intent(inout) :: self
    type(hhr_data_t), intent(in) :: cluster
    character(:), allocatable, intent(out) :: message
    type(lu_t) :: lu

    call lu%factor(cluster%reduced_stiffness)
    if (lu%is_singular) then
      message = 'the reduced stiffness (' // to_text(cluster%n_modes) // ' modes) is numerically singular: its reciprocal ' &
        // 'condition number is ' // to_text(lu%reciprocal_condition) // '; the equations of the reduced integration domain ' &
        // 'do not determine every mode (a larger pod_tolerance or a zone of interest mends that)'
      return
    end if
    self%multiplier_response = lu%solve(transpose(cluster%contact_matrix))
    self%condensed = matmul(cluster%contact_matrix, self%multiplier_response)
    if (allocated(self%response)) deallocate (self%response)
    allocate (self%response(cluster%n_rows + cluster%n_modes, size(cluster%load, 2)))
    self%response(cluster%n_rows + 1:, :) = lu%solve(cluster%load)
    self%response(:cluster%n_rows, :) = cluster%gap - matmul(cluster%contact_matrix, self%response(cluster%n_rows + 1:, :))
  end subroutine create

  !> Room for assemble.
  pure subroutine reserve(self, cluster)
    class(hhr_system_t), intent(inout) :: self
    type(hhr_data_t), intent(in) :: cluster

    associate (n => cluster%n_modes, n_rows => cluster%n_rows)
      allocate (self%condensed(n_rows, n_rows), self%multiplier_response(n, n_rows), self%factors(n, n))
      allocate (self%lifting_load(n, size(cluster%lifted_terms)), self%work(n), self%pivots(n), self%signs(n))
      allocate (self%moduli(size(cluster%varying%kinds)))
    end associate
  end subroutine reserve

  !> The system at a point. Cost: 2/3 n_modes^3 + 2 n_modes^2 (n_rows + number of moduli).
  subroutine assemble(self, cluster, theta, response, is_singular)
    class(hhr_system_t), target, intent(inout) :: self
    !> that of reserve
    type(hhr_data_t), intent(in) :: cluster
    !> values of the model's terms
    real(rk), contiguous, intent(in) :: theta(:)
    !> (q, K_r^-1 F), shape (n_rows + n_modes)
    real(rk), contiguous, intent(inout) :: response(:)
    !> K_r is, numerically: there is no system
    logical, intent(out) :: is_singular
    real(rk), pointer, contiguous :: flat(:)
    real(rk) :: norm
    integer :: i, info

    call cluster%varying%moduli_at(theta, self%moduli)
    associate (n => cluster%n_modes, n_rows => cluster%n_rows)
      self%factors = cluster%reduced_stiffness
      flat(1:n**2) => self%factors
      call multiply(1.0_rk, cluster%varying%parts, self%moduli, 1.0_rk, flat)
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
      call solve_lu(n, self%factors, self%pivots, response(n_rows + 1:))
      call multiply(1.0_rk, cluster%gap, theta, 0.0_rk, response(:n_rows))
      call multiply(-1.0_rk, cluster%contact_matrix, response(n_rows + 1:), 1.0_rk, response(:n_rows))
    end associate
  end subroutine assemble

  !> [force] F of the reduced equations.
  subroutine load_at(cluster, theta, lifting_load, load)
    type(hhr_data_t), intent(in) :: cluster
    real(rk), contiguous, intent(in) :: theta(:)
    !> [force] what varies, shape (n_modes, n_lifted_terms)
    real(rk), contiguous, intent(in) :: lifting_load(:, :)
    real(rk), contiguous, intent(inout) :: load(:)

    call multiply(1.0_rk, cluster%load, theta, 0.0_rk, load)
    call add_lifted(cluster, 1.0_rk, lifting_load, theta, load)
  end subroutine load_at

  !> gamma under the forces of the domain.
  subroutine coordinates(self, response, multipliers, values)
    class(hhr_system_t), intent(in) :: self
    !> response theta, shape (n_rows + n_modes)
    real(rk), intent(in) :: response(:)
    !> [force] shape (n_rows)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> [length] shape (n_modes)
    real(rk), contiguous, intent(inout) :: values(:)

    values = response(size(multipliers) + 1:)
    call multiply(-1.0_rk, self%multiplier_response, multipliers, 1.0_rk, values)
  end subroutine coordinates
end module sig_hhr_system
