! SPDX-License-Identifier: BSD-3-Clause
!> The stiffness as a sum of terms, K = K_0 + sum over q of theta_q K_q: of each material whose elastic constants depend on the
!> parameters the bulk and the shear part, with the modulus as theta_q. Both are positive semidefinite, and theta_q > 0.
module sig_stiffness_terms
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: hooke_term, n_hooke_terms
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: stiffness_term_t, body_of_term, body_of_rest, list_stiffness_terms

  type :: stiffness_term_t
    !> of the deck
    integer :: material = 1
    !> of hooke_term
    integer :: i_hooke = 1
  end type stiffness_term_t

contains

  !> Bulk and shear of one material after the other.
  pure subroutine list_stiffness_terms(is_varying, parts)
    !> which materials' constants depend on the parameters
    logical, intent(in) :: is_varying(:)
    type(stiffness_term_t), allocatable, intent(out) :: parts(:)
    integer :: i, i_hooke, n

    allocate (parts(n_hooke_terms * count(is_varying)))
    n = 0
    do i = 1, size(is_varying)
      if (.not. is_varying(i)) cycle
      do i_hooke = 1, n_hooke_terms
        n = n + 1
        parts(n)%material = i
        parts(n)%i_hooke = i_hooke
      end do
    end do
  end subroutine list_stiffness_terms

  !> The bodies with the law of one term per unit of its modulus: their stiffness is K_q.
  subroutine body_of_term(part, body, own)
    type(stiffness_term_t), intent(in) :: part
    type(elastic_body_t), intent(in) :: body
    type(elastic_body_t), intent(out) :: own
    real(rk) :: matrices(size(body%stress_matrix, 1), size(body%stress_matrix, 2), size(body%stress_matrix, 3))

    own = body
    matrices = 0
    matrices(:, :, part%material) = hooke_term(body%model, part%i_hooke)
    call own%set_stresses(matrices)
  end subroutine body_of_term

  !> The bodies with what is left of their law without these terms: their stiffness is K_0.
  subroutine body_of_rest(parts, body, own)
    type(stiffness_term_t), intent(in) :: parts(:)
    type(elastic_body_t), intent(in) :: body
    type(elastic_body_t), intent(out) :: own
    real(rk) :: matrices(size(body%stress_matrix, 1), size(body%stress_matrix, 2), size(body%stress_matrix, 3))
    integer :: i

    own = body
    matrices = body%stress_matrix
    do i = 1, size(parts)
      matrices(:, :, parts(i)%material) = 0
    end do
    call own%set_stresses(matrices)
  end subroutine body_of_rest
end module sig_stiffness_terms
