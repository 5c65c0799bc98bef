! SPDX-License-Identifier: BSD-3-Clause
!> Writes the history of the enrichment with hat functions: enrichment.csv.
module sig_enrichment_table
  use sig_errors, only: error_t
  use sig_file_system, only: write_text_file
  use sig_hhr_data, only: enrichment_history_t
  use sig_model, only: model_t
  use sig_reduced_hhr, only: reduced_hhr_t
  use sig_text, only: csv_number, to_text
  implicit none(type, external)
  private
  public :: write_enrichment_table

contains

  !> Writes enrichment.csv to the path: a head line, then for each hyper-reduced cluster a line for the basis without hats (hat 0)
  !> and one per hat function, in the order of the choice. A line has what holds with all hats up to this one: the sum of the
  !> numbers of POD modes and hats (`n_columns`), rank, condition number and ratio of singular values of the contact rows, condition
  !> number of the stiffness. `pair` is the contact row of the hat, `node` its node in the order of the mesh file, both 1-based and
  !> 0 for hat 0. A model without such clusters gives the head line only. Local. Errors: the file cannot be written.
  subroutine write_enrichment_table(model, path, error)
    type(model_t), intent(in) :: model
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: text
    integer :: i, i_cluster

    text = 'cluster,hat,pair,node,n_columns,rank,condition_number,singular_ratio,stiffness_condition' // new_line('a')
    do i_cluster = 1, model%n_clusters()
      select type (part => model%parts(i_cluster)%reduced)
      type is (reduced_hhr_t)
        do i = 1, size(part%data%history%rows)
          text = text // to_text(i_cluster) // ',' // table_row(part%data%history, i) // new_line('a')
        end do
      end select
    end do
    call write_text_file(path, text, error)
  end subroutine write_enrichment_table

  !> Returns a line of enrichment.csv, without the number of the cluster, the comma behind it, and the line end.
  pure function table_row(history, i) result(row)
    type(enrichment_history_t), intent(in) :: history
    !> position in the history: 1 for the basis without hats, k + 1 for hat k
    integer, intent(in) :: i
    character(:), allocatable :: row

    row = to_text(i - 1) // ',' // to_text(history%rows(i)) // ',' // to_text(history%nodes(i)) // ',' // &
      to_text(history%n_columns(i)) // ',' // to_text(history%ranks(i)) // ',' // csv_number(history%condition_numbers(i)) // &
      ',' // csv_number(history%singular_ratios(i)) // ',' // csv_number(history%stiffness_conditions(i))
  end function table_row
end module sig_enrichment_table
